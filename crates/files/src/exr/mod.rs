//! EXR files, block by block.
//!
//! A file is patched, not rebuilt: its header and every block without a denoised channel are copied
//! byte for byte, so other parts, attributes, previews and smaller mip levels stay unchanged. Only
//! blocks with denoised channels are unpacked, changed and packed again.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::{EnvironmentMap, IntegerBounds, SampleType};

use self::text::name;
use ::exr::meta::header::Header;

use self::index::Block;
use super::escape::escaped;
use super::format::open;
use super::layers::{Part, Place};
use super::limits::Limits;
use super::pick::Pick;
use super::{Problem, guard};
use wgdenoise::Image;

mod index;
mod parallel;
mod pixels;
mod scan;
pub(crate) mod text;
mod write;

pub(super) use write::{Change, Samples, write_rgb};

/// An open EXR file: its header and the positions of its blocks, but no pixels.
#[derive(Debug)]
pub struct ExrFile {
    file: File,
    /// Everything before the table of blocks, as stored in the file.
    head: Vec<u8>,
    meta: MetaData,
    blocks: Vec<Block>,
    /// How large images may be.
    pub(crate) limits: Limits,
}

impl ExrFile {
    /// Reads the header and finds the blocks.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or too large, or uses an unsupported feature.
    pub fn open(path: &Path, limits: Limits) -> Result<Self, Problem> {
        let mut file = open(path)?;
        let len = file.metadata().map_err(Problem::Read)?.len();
        let head_len = scan::scan(BufReader::new(&file), len)?;
        let mut head = vec![0; head_len as usize];
        file.seek(SeekFrom::Start(0)).map_err(Problem::Read)?;
        file.read_exact(&mut head).map_err(Problem::Read)?;
        let meta = read_meta(&head)?;
        guard::check_header(&meta, limits, head_len, len)?;
        let blocks = index::read(&file, &meta, head_len, len)?;
        Ok(Self { file, head, meta, blocks, limits })
    }

    /// The names of parts and channels.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let part = |header: &Header| {
            let own = &header.own_attributes;
            Part {
                name: own.layer_name.as_ref().map(name),
                channels: header.channels.list.iter().map(|c| name(&c.name)).collect(),
                view: own.view_name.as_ref().map(name),
                views: own.multi_view_names.iter().flatten().map(name).collect(),
            }
        };
        self.meta.headers.iter().map(part).collect()
    }

    /// The header of each part.
    #[must_use]
    pub fn headers(&self) -> &[Header] {
        &self.meta.headers
    }

    /// The rectangle of pixels that a part covers, in the coordinates of the whole picture.
    #[must_use]
    pub fn window(&self, part: usize) -> IntegerBounds {
        self.meta.headers[part].data_window()
    }

    /// Whether a part is a latitude–longitude panorama around the viewer, so that its left and
    /// right edges touch.
    #[must_use]
    pub fn is_panorama(&self, part: usize) -> bool {
        let header = &self.meta.headers[part];
        let [data, display] = [header.data_window(), header.shared_attributes.display_window]
            .map(|window| (window.position.x(), window.size.width()));
        let map = header.own_attributes.environment_map;
        map == Some(EnvironmentMap::LatitudeLongitude) && data == display
    }

    /// Whether a part holds the six faces of a cube around the viewer, one below the other.
    #[must_use]
    pub fn is_cube(&self, part: usize) -> bool {
        self.meta.headers[part].own_attributes.environment_map == Some(EnvironmentMap::Cube)
    }

    /// Reads layers and single channels at full size, each in its own part's window. Unpacks every
    /// part once.
    ///
    /// # Errors
    /// If a channel is neither half nor float, is subsampled, or a block is damaged.
    pub fn read(
        &self,
        picks: &[&Pick],
        planes: &[Place],
    ) -> Result<(Vec<Image>, Vec<Vec<f32>>), Problem> {
        picks.iter().try_for_each(|pick| self.check(pick))?;
        let places: Vec<_> = picks.iter().flat_map(|p| p.channels).chain(planes.to_vec()).collect();
        let mut images: Vec<_> = picks.iter().map(|p| self.blank(p)).collect::<Result<_, _>>()?;
        let area = |place: &Place| self.meta.headers[place.part].layer_size.area();
        let mut values: Vec<_> = planes.iter().map(|place| vec![0.0; area(place)]).collect();
        self.for_each_block(&places, |i, width, bounds, samples| {
            let pixels = bounds_in(width, bounds).zip(samples);
            if let Some(plane) = i.checked_sub(3 * images.len()) {
                pixels.for_each(|(at, v)| values[plane][at] = *v);
            } else {
                let image = images[i / 3].pixels_mut();
                pixels.for_each(|(at, v)| image[at][i % 3] = *v);
            }
        })?;
        Ok((images, values))
    }

    fn blank(&self, pick: &Pick) -> Result<Image, Problem> {
        let size = self.meta.headers[pick.part()].layer_size;
        let blank = Image::filled(size.width() as u32, size.height() as u32, [0.0; 3]);
        blank.map_err(|error| Problem::TooLarge(error.to_string()))
    }

    /// Refuses layers that cannot be read or written.
    ///
    /// # Errors
    /// If a channel holds integers, a part is subsampled, or the channels are in parts that cover
    /// different rectangles.
    pub fn check(&self, pick: &Pick) -> Result<(), Problem> {
        pick.channels.iter().try_for_each(|place| self.check_channel(*place))?;
        let window = self.window(pick.part());
        if pick.channels.iter().all(|place| self.window(place.part) == window) {
            return Ok(());
        }
        let layer = escaped(&pick.layer);
        Err(Problem::Unsupported(format!(
            "the channels of `{layer}` are in parts that cover different rectangles of the picture"
        )))
    }

    /// Refuses a channel that cannot be read or written.
    ///
    /// # Errors
    /// If it holds integers or its part is subsampled.
    pub fn check_channel(&self, place: Place) -> Result<(), Problem> {
        let header = &self.meta.headers[place.part];
        guard::check_sampling(header)?;
        let channel = &header.channels.list[place.channel];
        if channel.sample_type != SampleType::U32 {
            return Ok(());
        }
        Err(Problem::Unsupported(format!(
            "channel `{}` holds integers (uint), and only half and float are supported",
            escaped(&name(&channel.name))
        )))
    }

    /// Unpacks all full-size blocks that hold `places`. `put` gets the index of a place, the width
    /// of its part, and the block's bounds and samples.
    fn for_each_block(
        &self,
        places: &[Place],
        mut put: impl FnMut(usize, usize, IntegerBounds, &[f32]),
    ) -> Result<(), Problem> {
        let mut of_part: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, place) in places.iter().enumerate() {
            of_part.entry(place.part).or_default().push(i);
        }
        for (part, wanted) in of_part {
            let header = &self.meta.headers[part];
            let blocks = self.full_size_blocks(part)?;
            for batch in blocks.chunks(parallel::batch(header)) {
                let unpacked = parallel::map(self.load(batch)?, |(block, packed)| {
                    let (bounds, bytes) = pixels::unpack(header, block, packed)?;
                    let samples =
                        |&i: &usize| pixels::extract(header, bounds, &bytes, places[i].channel);
                    Ok((bounds, wanted.iter().map(samples).collect::<Vec<_>>()))
                });
                for result in unpacked {
                    let (bounds, channels) = result?;
                    for (&i, samples) in wanted.iter().zip(&channels) {
                        put(i, header.layer_size.width(), bounds, samples);
                    }
                }
            }
        }
        Ok(())
    }

    /// Reads the packed pixels of some blocks.
    fn load<'a>(&self, blocks: &[&'a Block]) -> Result<Vec<(&'a Block, Vec<u8>)>, Problem> {
        let load = |&block: &&'a Block| {
            self.bytes(block.offset + block.head as u64, block.stored).map(|bytes| (block, bytes))
        };
        blocks.iter().map(load).collect()
    }

    fn bytes(&self, offset: u64, len: usize) -> Result<Vec<u8>, Problem> {
        let mut bytes = vec![0; len];
        let mut file = &self.file;
        file.seek(SeekFrom::Start(offset)).map_err(Problem::Read)?;
        file.read_exact(&mut bytes).map_err(Problem::Read)?;
        Ok(bytes)
    }

    /// The blocks of a part at full size, each present once and plausible.
    fn full_size_blocks(&self, part: usize) -> Result<Vec<&Block>, Problem> {
        let header = &self.meta.headers[part];
        let full =
            |b: &&Block| b.part == part && b.tile.level_index.0 == 0 && b.tile.level_index.1 == 0;
        let blocks: Vec<_> = self.blocks.iter().filter(full).collect();
        for block in &blocks {
            guard::check_ratio(header, block.stored, pixels::bounds(header, block)?)?;
        }
        let mut places: Vec<_> =
            blocks.iter().map(|b| (b.tile.tile_index.0, b.tile.tile_index.1)).collect();
        places.sort_unstable();
        places.dedup();
        let (size, block) = (header.layer_size, header.max_block_pixel_size());
        let expected =
            size.width().div_ceil(block.width()) * size.height().div_ceil(block.height());
        if places.len() != expected || blocks.len() != expected {
            return Err(Problem::Damaged(format!(
                "is damaged: {} of the {expected} blocks of part {part} are present",
                places.len()
            )));
        }
        Ok(blocks)
    }
}

/// Indices of a block's pixels in a picture of this width, row by row.
fn bounds_in(width: usize, bounds: IntegerBounds) -> impl Iterator<Item = usize> {
    let (x, y) = (bounds.position.x() as usize, bounds.position.y() as usize);
    let rows = (0..bounds.size.height()).map(move |row| (y + row) * width + x);
    rows.flat_map(move |start| start..start + bounds.size.width())
}

fn read_meta(head: &[u8]) -> Result<MetaData, Problem> {
    let meta = MetaData::read_from_buffered(head, false).map_err(|error| match error {
        ::exr::error::Error::NotSupported(what) => {
            Problem::Unsupported(format!("has an unsupported header ({})", escaped(&what)))
        }
        error if error.to_string().contains("compression attribute") => {
            Problem::Unsupported("names an unknown compression; write it with ZIP or PIZ".into())
        }
        error => {
            Problem::Damaged(format!("has a damaged header ({})", escaped(&error.to_string())))
        }
    })?;
    if meta.headers.is_empty() {
        return Err(Problem::Damaged("has no parts".into()));
    }
    Ok(meta)
}
