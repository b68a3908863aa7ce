//! Writes the same file with some channels replaced, or a plain new file.

use std::collections::{HashMap, HashSet};
use std::io::{Seek, SeekFrom, Write};

use ::exr::meta::attribute::{
    ChannelDescription, Chromaticities, Compression, IntegerBounds, LineOrder, SampleType,
};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage,
};

use super::index::Block;
use super::{ExrFile, parallel, pixels};
use crate::Problem;
use crate::layers::Place;
use crate::pick::Pick;
use wgdenoise::Image;

/// New samples for one channel.
pub(crate) struct Change<'a> {
    pub(crate) place: Place,
    /// The rectangle that the samples cover.
    pub(crate) window: IntegerBounds,
    pub(crate) samples: Samples<'a>,
}

/// The source of new samples.
pub(crate) enum Samples<'a> {
    /// One component of each pixel.
    Component(&'a Image, usize),
    /// The mean of each pixel's components.
    Gray(&'a Image),
    /// Single values, row by row.
    Plane(&'a [f32]),
}

impl<'a> Change<'a> {
    /// Replaces a layer by an image; a single channel gets the mean of three.
    pub(crate) fn of_image(pick: &Pick, window: IntegerBounds, image: &'a Image) -> Vec<Self> {
        if pick.is_gray() {
            return vec![Self { place: pick.channels[0], window, samples: Samples::Gray(image) }];
        }
        let components = pick.channels.into_iter().enumerate();
        let samples = |component| Samples::Component(image, component);
        components.map(|(i, place)| Self { place, window, samples: samples(i) }).collect()
    }

    /// The new sample at a position in the whole picture.
    fn at(&self, x: i64, y: i64) -> Option<f32> {
        let (corner, size) = (self.window.position, self.window.size);
        let x = usize::try_from(x - i64::from(corner.x())).ok().filter(|x| *x < size.width())?;
        let y = usize::try_from(y - i64::from(corner.y())).ok().filter(|y| *y < size.height())?;
        let i = y * size.width() + x;
        Some(match self.samples {
            Samples::Component(image, component) => image.pixels()[i][component],
            Samples::Gray(image) => image.pixels()[i].iter().sum::<f32>() / 3.0,
            Samples::Plane(values) => values[i],
        })
    }
}

/// The changes of each part.
type Changes<'a> = HashMap<usize, Vec<&'a Change<'a>>>;

impl ExrFile {
    /// Writes this file with some channels replaced. Returns how many values were too large for
    /// half and clamped.
    ///
    /// Blocks without such a channel are copied. Smaller mip levels stay as they were.
    ///
    /// # Errors
    /// If reading or writing fails.
    pub(crate) fn write(
        &self,
        out: &mut (impl Write + Seek),
        changes: &[Change<'_>],
    ) -> Result<u64, Problem> {
        let changes = by_part(changes);
        let mut table = vec![0_u8; 8 * self.blocks.len()];
        out.write_all(&self.head).map_err(Problem::Write)?;
        out.write_all(&table).map_err(Problem::Write)?;
        let mut position = (self.head.len() + table.len()) as u64;
        let mut clamped = 0;
        let batches = changes.keys().map(|&part| parallel::batch(&self.meta.headers[part]));
        let most = batches.min().unwrap_or(1);
        let mut rest = self.blocks.as_slice();
        while !rest.is_empty() {
            // Blocks of other parts may be larger than the changed ones.
            let count = parallel::leading(rest.iter().map(|b| b.stored), most);
            let (batch, later) = rest.split_at(count);
            rest = later;
            for (block, (bytes, count)) in batch.iter().zip(self.change(batch, &changes)?) {
                table[8 * block.slot..][..8].copy_from_slice(&position.to_le_bytes());
                out.write_all(&bytes).map_err(Problem::Write)?;
                position += bytes.len() as u64;
                clamped += count;
            }
        }
        out.seek(SeekFrom::Start(self.head.len() as u64)).map_err(Problem::Write)?;
        out.write_all(&table).map_err(Problem::Write)?;
        Ok(clamped)
    }

    /// The parts in which other channels change slightly, because they share blocks with the
    /// changed ones and are compressed lossily again.
    pub(crate) fn rewritten_lossily(&self, changes: &[Change<'_>]) -> Vec<usize> {
        let mut parts: Vec<_> = by_part(changes).into_iter().collect();
        parts.sort_unstable_by_key(|(part, _)| *part);
        let loses_others = |(part, changes): &(usize, Vec<&Change<'_>>)| {
            let changed: HashSet<_> = changes.iter().map(|change| change.place.channel).collect();
            let header = &self.meta.headers[*part];
            let mut channels = header.channels.list.iter().enumerate();
            channels.any(|(i, channel)| !changed.contains(&i) && loses(header.compression, channel))
        };
        parts.into_iter().filter(loses_others).map(|(part, _)| part).collect()
    }

    /// Whether the part has smaller mip levels, which are not denoised.
    #[must_use]
    pub fn has_levels(&self, part: usize) -> bool {
        self.blocks
            .iter()
            .any(|b| b.part == part && (b.tile.level_index.0 > 0 || b.tile.level_index.1 > 0))
    }

    /// Builds each block as it will be written, head included, and counts clamped values.
    fn change(
        &self,
        blocks: &[Block],
        changes: &Changes<'_>,
    ) -> Result<Vec<(Vec<u8>, u64)>, Problem> {
        let load = |b: &Block| self.bytes(b.offset, b.head + b.stored);
        let loaded: Result<Vec<_>, _> = blocks.iter().map(load).collect();
        let pairs = blocks.iter().zip(loaded?).collect();
        let changed = parallel::map(pairs, |(block, bytes): (&Block, Vec<u8>)| {
            let at_full_size = block.tile.level_index.0 == 0 && block.tile.level_index.1 == 0;
            match changes.get(&block.part) {
                Some(changes) if at_full_size => self.repaint(block, bytes, changes),
                _ => Ok((bytes, 0)),
            }
        });
        changed.into_iter().collect()
    }

    fn repaint(
        &self,
        block: &Block,
        mut bytes: Vec<u8>,
        changes: &[&Change<'_>],
    ) -> Result<(Vec<u8>, u64), Problem> {
        let header = &self.meta.headers[block.part];
        let packed = bytes.split_off(block.head);
        let (bounds, mut samples) = pixels::unpack(header, block, packed)?;
        let corner = header.own_attributes.layer_position;
        let (left, top) = (i64::from(corner.x()), i64::from(corner.y()));
        let mut clamped = 0;
        for change in changes {
            let value = |x: usize, y: usize| change.at(left + x as i64, top + y as i64);
            let channel = change.place.channel;
            clamped += pixels::replace(header, bounds, &mut samples, channel, value);
        }
        let packed = pixels::pack(header, bounds, samples)?;
        let size = i32::try_from(packed.len())
            .map_err(|_| Problem::TooLarge("has a block of over 2 GiB".into()))?;
        bytes[block.head - 4..].copy_from_slice(&size.to_le_bytes());
        bytes.extend(packed);
        Ok((bytes, clamped))
    }
}

fn by_part<'a>(changes: &'a [Change<'a>]) -> Changes<'a> {
    let mut parts = Changes::new();
    for change in changes {
        parts.entry(change.place.part).or_default().push(change);
    }
    parts
}

/// Whether a compression changes a channel each time: B44 changes half, DWA changes channels named
/// like color or luminance; PXR24 keeps its 24 bits.
fn loses(compression: Compression, channel: &ChannelDescription) -> bool {
    let name = channel.name.to_string();
    let letter = name.rsplit('.').next().unwrap_or_default();
    match compression {
        Compression::B44 | Compression::B44A => channel.sample_type == SampleType::F16,
        Compression::DWAA(_) | Compression::DWAB(_) => {
            channel.sample_type != SampleType::U32
                && matches!(letter, "R" | "G" | "B" | "Y" | "BY" | "RY")
        }
        _ => false,
    }
}

/// Writes a new file: R, G, B and, if given, A as float, losslessly compressed. Without primaries,
/// the colors are sRGB's.
///
/// # Errors
/// If writing fails.
pub(crate) fn write_rgb(
    out: &mut (impl Write + Seek),
    image: &Image,
    alpha: Option<Vec<f32>>,
    primaries: Option<Chromaticities>,
    pixel_aspect: f32,
) -> Result<(), Problem> {
    let plane = |c: usize| image.pixels().iter().map(|p| p[c]).collect();
    let color = ["R", "G", "B"].into_iter().zip((0..3).map(plane));
    let channels = color.chain(alpha.map(|alpha| ("A", alpha)));
    let channels = channels.map(|(name, plane)| AnyChannel::new(name, FlatSamples::F32(plane)));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width() as usize, image.height() as usize);
    let channels = AnyChannels::sort(channels.collect());
    let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
    let mut image = ::exr::image::Image::from_layer(layer);
    (image.attributes.chromaticities, image.attributes.pixel_aspect) = (primaries, pixel_aspect);
    let written = image.write().to_buffered(out);
    written.map_err(|error| match error {
        ::exr::error::Error::Io(error) => Problem::Write(error),
        error => Problem::Unsupported(format!("cannot be written as EXR: {error}")),
    })
}
