//! Writing: the same file with three channels replaced, or a plain new file.

use std::io::{Seek, SeekFrom, Write};

use ::exr::meta::attribute::{
    ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType,
};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage,
};

use super::index::Block;
use super::{ExrFile, parallel, pixels};
use crate::Problem;
use crate::choice::Pick;
use wgdenoise::Image;

impl ExrFile {
    /// Writes this file with the pixels of `target` replaced by `color`, whose top left pixel
    /// is that of `window`. Returns how many values were too large for half and clamped.
    ///
    /// Every other block is copied. Smaller mip levels stay as they were.
    ///
    /// # Errors
    /// If reading or writing fails.
    pub fn write(
        &self,
        out: &mut (impl Write + Seek),
        target: &Pick,
        window: IntegerBounds,
        color: &Image,
    ) -> Result<u64, Problem> {
        let mut table = vec![0_u8; 8 * self.blocks.len()];
        out.write_all(&self.head).map_err(Problem::Write)?;
        out.write_all(&table).map_err(Problem::Write)?;
        let mut position = (self.head.len() + table.len()) as u64;
        let mut clamped = 0;
        let most = parallel::batch(&self.meta.headers[target.part]);
        let mut rest = self.blocks.as_slice();
        while !rest.is_empty() {
            // The blocks of other parts may be larger than those of the target's.
            let count = parallel::leading(rest.iter().map(|b| b.stored), most);
            let (batch, later) = rest.split_at(count);
            rest = later;
            let changed = self.change(batch, target, window, color)?;
            for (block, (bytes, count)) in batch.iter().zip(changed) {
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

    /// Whether writing `target` changes other channels of its part slightly, because they share
    /// blocks with the color and go through lossy compression again.
    #[must_use]
    pub fn rewrites_others_lossily(&self, target: &Pick) -> bool {
        let header = &self.meta.headers[target.part];
        let mut channels = header.channels.list.iter().enumerate();
        channels
            .any(|(i, channel)| !target.channels.contains(&i) && loses(header.compression, channel))
    }

    /// Whether the part has smaller mip levels, which are not denoised.
    #[must_use]
    pub fn has_levels(&self, part: usize) -> bool {
        self.blocks
            .iter()
            .any(|b| b.part == part && (b.tile.level_index.0 > 0 || b.tile.level_index.1 > 0))
    }

    /// Each block as it will be written, head included, and how many values were clamped.
    fn change(
        &self,
        blocks: &[Block],
        target: &Pick,
        window: IntegerBounds,
        color: &Image,
    ) -> Result<Vec<(Vec<u8>, u64)>, Problem> {
        let load = |b: &Block| self.bytes(b.offset, b.head + b.stored);
        let loaded: Result<Vec<_>, _> = blocks.iter().map(load).collect();
        let pairs = blocks.iter().zip(loaded?).collect();
        let changed = parallel::map(pairs, |(block, bytes): (&Block, Vec<u8>)| {
            let at_full_size = block.tile.level_index.0 == 0 && block.tile.level_index.1 == 0;
            if block.part == target.part && at_full_size {
                self.repaint(block, bytes, target, window, color)
            } else {
                Ok((bytes, 0))
            }
        });
        changed.into_iter().collect()
    }

    fn repaint(
        &self,
        block: &Block,
        mut bytes: Vec<u8>,
        target: &Pick,
        window: IntegerBounds,
        color: &Image,
    ) -> Result<(Vec<u8>, u64), Problem> {
        let header = &self.meta.headers[block.part];
        let packed = bytes.split_off(block.head);
        let (bounds, mut samples) = pixels::unpack(header, block, packed)?;
        let shift = header.own_attributes.layer_position - window.position;
        let pixel = |x: usize, y: usize| {
            let at = (x as i64 + i64::from(shift.x()), y as i64 + i64::from(shift.y()));
            let (x, y) = (u32::try_from(at.0).ok()?, u32::try_from(at.1).ok()?);
            (x < color.width() && y < color.height()).then(|| color.row(y)[x as usize])
        };
        let clamped = pixels::replace(header, bounds, &mut samples, target.channels, pixel);
        let packed = pixels::pack(header, bounds, samples)?;
        let size = i32::try_from(packed.len())
            .map_err(|_| Problem::TooLarge("has a block of over 2 GiB".into()))?;
        bytes[block.head - 4..].copy_from_slice(&size.to_le_bytes());
        bytes.extend(packed);
        Ok((bytes, clamped))
    }
}

/// Whether a compression changes a channel each time: B44 changes half, DWA what is named like color
/// or luminance; the 24 bits of PXR24 stay.
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

/// Writes a new file: R, G, B and, if given, A as float, losslessly compressed.
///
/// # Errors
/// If writing fails.
pub(crate) fn write_rgb(
    out: &mut (impl Write + Seek),
    image: &Image,
    alpha: Option<Vec<f32>>,
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
    let written = ::exr::image::Image::from_layer(layer).write().to_buffered(out);
    written.map_err(|error| match error {
        ::exr::error::Error::Io(error) => Problem::Write(error),
        error => Problem::Unsupported(format!("cannot be written as EXR: {error}")),
    })
}
