//! The samples of an unpacked block: each row holds all of the first channel, then all of the next.

use ::exr::meta::attribute::{IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use half::f16;

use super::index::Block;
use crate::{Problem, guard};
use wgdenoise::panics::caught;

/// The largest half.
const MAX_HALF: f32 = 65504.0;

/// The rectangle of a block, relative to the corner of its part's data window.
pub(super) fn bounds(header: &Header, block: &Block) -> Result<IntegerBounds, Problem> {
    let bounds = header.get_absolute_block_pixel_coordinates(block.tile).map_err(damaged)?;
    bounds.validate(Some(header.max_block_pixel_size())).map_err(damaged)?;
    Ok(bounds)
}

/// Unpacks a block's samples, in the machine's byte order.
pub(super) fn unpack(
    header: &Header,
    block: &Block,
    packed: Vec<u8>,
) -> Result<(IntegerBounds, Vec<u8>), Problem> {
    let bounds = bounds(header, block)?;
    guard::check_dwa(header, &packed, bounds)?;
    // On damaged blocks, B44's arithmetic overflows, which checked builds turn into panics.
    let decode =
        || header.compression.decompress_image_section_from_le(header, packed, bounds, false);
    match caught(decode) {
        Some(unpacked) => Ok((bounds, unpacked.map_err(damaged)?)),
        None => Err(Problem::Damaged("is damaged: a block cannot be unpacked".into())),
    }
}

/// Packs a block's samples: the reverse of [`unpack`].
pub(super) fn pack(
    header: &Header,
    bounds: IntegerBounds,
    bytes: Vec<u8>,
) -> Result<Vec<u8>, Problem> {
    let packed = header.compression.compress_image_section_to_le(header, bytes, bounds);
    packed.map_err(|e| Problem::Unsupported(format!("cannot be compressed again: {e}")))
}

/// Extracts one channel of a block, row by row.
pub(super) fn extract(
    header: &Header,
    bounds: IntegerBounds,
    bytes: &[u8],
    channel: usize,
) -> Vec<f32> {
    let samples = Samples::of(header, bounds, channel);
    (0..bounds.size.area()).map(|i| samples.get(bytes, i)).collect()
}

/// Replaces one channel of a block wherever `value` returns one for the pixel; returns how many
/// values were too large for half.
pub(super) fn replace(
    header: &Header,
    bounds: IntegerBounds,
    bytes: &mut [u8],
    channel: usize,
    value: impl Fn(usize, usize) -> Option<f32>,
) -> u64 {
    let samples = Samples::of(header, bounds, channel);
    let mut clamped = 0;
    for i in 0..bounds.size.area() {
        let x = bounds.position.x() as usize + i % bounds.size.width();
        let y = bounds.position.y() as usize + i / bounds.size.width();
        if let Some(value) = value(x, y) {
            clamped += u64::from(samples.set(bytes, i, value));
        }
    }
    clamped
}

/// The positions of one channel's samples in a block.
struct Samples {
    kind: SampleType,
    /// Pixels per row.
    width: usize,
    /// Bytes per row, all channels.
    stride: usize,
    /// Bytes before the channel in each row.
    start: usize,
}

impl Samples {
    fn of(header: &Header, bounds: IntegerBounds, channel: usize) -> Self {
        let width = bounds.size.width();
        let list = &header.channels.list;
        let before: usize = list[..channel].iter().map(|c| c.sample_type.bytes_per_sample()).sum();
        let stride = width * header.channels.bytes_per_pixel;
        Self { kind: list[channel].sample_type, width, stride, start: width * before }
    }

    fn at(&self, i: usize) -> usize {
        let column = i % self.width * self.kind.bytes_per_sample();
        i / self.width * self.stride + self.start + column
    }

    fn get(&self, bytes: &[u8], i: usize) -> f32 {
        let at = self.at(i);
        match self.kind {
            SampleType::F16 => f16::from_ne_bytes([bytes[at], bytes[at + 1]]).to_f32(),
            SampleType::F32 => f32::from_bits(word(bytes, at)),
            SampleType::U32 => word(bytes, at) as f32,
        }
    }

    /// Stores a value; returns true if it was too large and the largest half was stored instead.
    fn set(&self, bytes: &mut [u8], i: usize, value: f32) -> bool {
        let at = self.at(i);
        match self.kind {
            SampleType::F16 => {
                let clamped = value.clamp(-MAX_HALF, MAX_HALF);
                bytes[at..at + 2].copy_from_slice(&f16::from_f32(clamped).to_ne_bytes());
                clamped != value
            }
            SampleType::F32 => {
                bytes[at..at + 4].copy_from_slice(&value.to_ne_bytes());
                false
            }
            SampleType::U32 => unreachable!("layers of integers are refused when opened"),
        }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_ne_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn damaged(error: ::exr::error::Error) -> Problem {
    match error {
        ::exr::error::Error::NotSupported(what) => {
            Problem::Unsupported(format!("has unsupported pixels ({what})"))
        }
        error => Problem::Damaged(format!("is damaged: a block cannot be unpacked ({error})")),
    }
}
