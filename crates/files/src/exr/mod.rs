//! EXR files, block by block.
//!
//! A file is patched, not rebuilt: its header and every block without the denoised color are copied
//! byte for byte, so other parts, attributes, previews and smaller mip levels come out as they came
//! in. Only the blocks with the color are unpacked, changed and packed again.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::{EnvironmentMap, IntegerBounds, SampleType};

use self::text::name;
use ::exr::meta::header::Header;

use self::index::Block;
use super::choice::Pick;
use super::escape::escaped;
use super::format::open;
use super::layers::Part;
use super::limits::Limits;
use super::{Problem, guard};
use wgdenoise::Image;

mod index;
mod parallel;
mod pixels;
mod scan;
pub(crate) mod text;
mod write;

pub(super) use write::write_rgb;

/// An open EXR file: its header and the positions of its blocks, but no pixels.
#[derive(Debug)]
pub struct ExrFile {
    file: File,
    /// Everything before the table of blocks, as it is in the file.
    head: Vec<u8>,
    meta: MetaData,
    blocks: Vec<Block>,
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
        Ok(Self { file, head, meta, blocks })
    }

    /// The names of parts and channels.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let part = |header: &Header| Part {
            name: header.own_attributes.layer_name.as_ref().map(name),
            channels: header.channels.list.iter().map(|c| name(&c.name)).collect(),
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

    /// Whether a part covers all directions around the viewer by latitude and longitude, so that its
    /// left and right edge touch.
    #[must_use]
    pub fn is_panorama(&self, part: usize) -> bool {
        let header = &self.meta.headers[part];
        let [data, display] = [header.data_window(), header.shared_attributes.display_window]
            .map(|window| (window.position.x(), window.size.width()));
        let map = header.own_attributes.environment_map;
        map == Some(EnvironmentMap::LatitudeLongitude) && data == display
    }

    /// Reads layers at full size, each in its own part's window.
    ///
    /// # Errors
    /// If a channel is neither half nor float, is subsampled, or a block is damaged.
    pub fn read(&self, picks: &[&Pick]) -> Result<Vec<Image>, Problem> {
        let mut images: Vec<Option<Image>> = vec![None; picks.len()];
        for part in 0..self.meta.headers.len() {
            let here: Vec<usize> = (0..picks.len()).filter(|&i| picks[i].part == part).collect();
            if here.is_empty() {
                continue;
            }
            here.iter().try_for_each(|&i| self.check(picks[i]))?;
            let channels: Vec<_> = here.iter().map(|&i| picks[i].channels).collect();
            for (i, image) in here.into_iter().zip(self.read_part(part, &channels)?) {
                images[i] = Some(image);
            }
        }
        Ok(images.into_iter().flatten().collect())
    }

    /// Refuses layers that cannot be read or written.
    ///
    /// # Errors
    /// If a channel holds integers or the part is subsampled.
    pub fn check(&self, pick: &Pick) -> Result<(), Problem> {
        let header = &self.meta.headers[pick.part];
        guard::check_sampling(header)?;
        let mut channels = pick.channels.iter().map(|&c| &header.channels.list[c]);
        match channels.find(|c| c.sample_type == SampleType::U32) {
            Some(channel) => Err(Problem::Unsupported(format!(
                "channel `{}` holds integers (uint), and only half and float are supported",
                escaped(&name(&channel.name))
            ))),
            None => Ok(()),
        }
    }

    fn read_part(&self, part: usize, channels: &[[usize; 3]]) -> Result<Vec<Image>, Problem> {
        let header = &self.meta.headers[part];
        let blocks = self.full_size_blocks(part)?;
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let blank = Image::filled(width as u32, height as u32, [0.0; 3]);
        let mut images = vec![blank.map_err(|e| Problem::Damaged(e.to_string()))?; channels.len()];
        for batch in blocks.chunks(parallel::batch(header)) {
            let unpacked = parallel::map(self.load(batch)?, |(block, packed)| {
                let (bounds, bytes) = pixels::unpack(header, block, packed)?;
                let area = |c: &[usize; 3]| pixels::extract(header, bounds, &bytes, *c);
                Ok((bounds, channels.iter().map(area).collect::<Vec<_>>()))
            });
            for result in unpacked {
                let (bounds, areas) = result?;
                for (image, area) in images.iter_mut().zip(&areas) {
                    pixels::place(image, bounds, area);
                }
            }
        }
        Ok(images)
    }

    /// The packed pixels of some blocks.
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

    /// The blocks of a part at its full size, each present once and plausible.
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
