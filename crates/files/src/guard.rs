//! Refuses hostile and broken EXR files before anything is allocated for their pixels.
//!
//! A header may claim any size; only what the file's length can back is believed.

use ::exr::meta::attribute::{Compression, IntegerBounds};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};

use super::error::Problem;
use super::escape::escaped;
use super::exr::text::name;
use super::limits::Limits;

/// Checks every part's claims against the limits and the file's length.
///
/// `header_end` is where the header ends and the table of block positions begins.
///
/// # Errors
/// If a part is deep or too large, or the file is too short for its table.
pub(super) fn check_header(
    meta: &MetaData,
    limits: Limits,
    header_end: u64,
    file_len: u64,
) -> Result<(), Problem> {
    for header in &meta.headers {
        check_part(header, limits)?;
    }
    let blocks: u128 = meta.headers.iter().map(|h| h.chunk_count as u128).sum();
    if u128::from(header_end) + 8 * blocks > u128::from(file_len) {
        return Err(Problem::Damaged(format!(
            "is cut off: its table of {blocks} blocks needs {} bytes and the file has {file_len}",
            u128::from(header_end) + 8 * blocks
        )));
    }
    Ok(())
}

fn check_part(header: &Header, limits: Limits) -> Result<(), Problem> {
    if header.deep {
        return Err(Problem::Unsupported(
            "holds deep data, which cannot be denoised; flatten it first".into(),
        ));
    }
    if header.channels.list.is_empty() {
        return Err(Problem::Damaged("has a part without channels".into()));
    }
    if matches!(header.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
        return Err(Problem::Unsupported(
            "is compressed with HTJ2K, which is not supported; write it with ZIP or PIZ".into(),
        ));
    }
    limits.check_size(header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    let bytes = block_bytes(header);
    if bytes > u128::from(limits.block_bytes()) {
        return Err(Problem::LargeBlocks { bytes, most: limits.block_bytes() });
    }
    Ok(())
}

/// The unpacked size of a part's largest block, in bytes.
pub(super) fn block_bytes(header: &Header) -> u128 {
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    let (w, h) = match header.blocks {
        BlockDescription::Tiles(t) => (t.tile_size.width(), t.tile_size.height()),
        BlockDescription::ScanLines => (width, header.compression.scan_lines_per_block()),
    };
    w.min(width) as u128 * h.min(height) as u128 * header.channels.bytes_per_pixel as u128
}

/// Refuses parts with channels that lack a sample for every pixel.
///
/// # Errors
/// If a channel is subsampled.
pub(super) fn check_sampling(header: &Header) -> Result<(), Problem> {
    let reduced = header.channels.list.iter().find(|c| c.sampling.area() != 1);
    reduced.map_or(Ok(()), |channel| {
        Err(Problem::Unsupported(format!(
            "channel `{}` has one sample for {}×{} pixels, which is not supported; write all \
             channels at full resolution",
            escaped(&name(&channel.name)),
            channel.sampling.width(),
            channel.sampling.height()
        )))
    })
}

/// Refuses a block that claims to unpack to more than its compression allows.
///
/// # Errors
/// If `unpacked` bytes cannot come from `stored` ones.
pub(super) fn check_ratio(
    header: &Header,
    stored: usize,
    bounds: IntegerBounds,
) -> Result<(), Problem> {
    let unpacked = bounds.size.area() as u128 * header.channels.bytes_per_pixel as u128;
    if unpacked > stored as u128 * most_unpacked_per_byte(header.compression) {
        return Err(Problem::Damaged(format!(
            "is damaged: a block of {stored} bytes cannot hold {unpacked} bytes of pixels"
        )));
    }
    Ok(())
}

/// Refuses a DWA block whose counters claim more than its pixels need: the decoder would allocate
/// that much.
///
/// # Errors
/// If a counter is too large or the block is too short for them.
pub(super) fn check_dwa(
    header: &Header,
    packed: &[u8],
    bounds: IntegerBounds,
) -> Result<(), Problem> {
    let unpacked = bounds.size.area() * header.channels.bytes_per_pixel;
    let is_dwa = matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if !is_dwa || packed.len() == unpacked {
        return Ok(());
    }
    // The DCT works on whole blocks of 8×8.
    let whole = bounds.size.width().next_multiple_of(8) * bounds.size.height().next_multiple_of(8);
    let most = (2 * whole * header.channels.bytes_per_pixel + 1024) as u64;
    let counters = packed.get(..8 * DWA_COUNTERS).into_iter().flat_map(|head| head.chunks_exact(8));
    let counters: Vec<_> = counters.map(|c| c.try_into().map_or(0, u64::from_le_bytes)).collect();
    let plausible = |&i: &usize| counters.get(i).is_some_and(|&c| c <= most);
    if DWA_UNPACKED_SIZES.iter().all(plausible) {
        return Ok(());
    }
    Err(Problem::Damaged("is damaged: a block's sizes contradict its number of pixels".into()))
}

/// The number of 64-bit counters that a DWA block begins with.
const DWA_COUNTERS: usize = 11;

/// The counters that hold sizes or counts after unpacking: other channels, two of run lengths, AC,
/// DC.
const DWA_UNPACKED_SIZES: [usize; 5] = [1, 6, 7, 8, 9];

/// Most bytes that a packed byte can yield, generously: deflate reaches 1032, PXR24 a third more;
/// DWA packs 64 equal values of a block into one before it deflates.
fn most_unpacked_per_byte(compression: Compression) -> u128 {
    match compression {
        Compression::Uncompressed => 1,
        Compression::DWAA(_) | Compression::DWAB(_) => 1 << 17,
        _ => 1 << 11,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use ::exr::meta::attribute::{ChannelDescription, Text};
    use ::exr::prelude::{SampleType, Vec2};

    pub(super) fn header(compression: Compression, tile: usize) -> Header {
        let channel = |name| ChannelDescription::named(name, SampleType::F16);
        let names = ["B", "G", "R"].map(channel).into_iter().collect();
        let tiles = ::exr::meta::attribute::TileDescription {
            tile_size: Vec2(tile, tile),
            level_mode: ::exr::meta::attribute::LevelMode::Singular,
            rounding_mode: ::exr::math::RoundingMode::Down,
        };
        let order = ::exr::meta::attribute::LineOrder::Increasing;
        Header::new(Text::from("C"), (16000, 16000), names).with_encoding(
            compression,
            BlockDescription::Tiles(tiles),
            order,
        )
    }

    #[test]
    fn a_tile_as_large_as_a_huge_picture_is_refused() {
        let check = |tile, limits| check_part(&header(Compression::ZIP16, tile), limits);
        assert!(check(256, Limits::default()).is_ok());
        let error = check(1 << 20, Limits::default()).unwrap_err().to_string();
        assert!(error.contains("blocks of 1536000000 bytes"), "{error}");
        assert!(check(1 << 20, Limits { pixels: 400_000_000 }).is_ok());
        assert!(check(256, Limits { pixels: 16000 * 16000 - 1 }).is_err());
    }

    #[test]
    fn a_block_cannot_claim_more_than_its_bytes_can_back() {
        let header = header(Compression::ZIP16, 256);
        let bounds = IntegerBounds::from_dimensions(Vec2(256, 256));
        assert!(check_ratio(&header, 400, bounds).is_ok());
        assert!(
            check_ratio(&header, 100, bounds).is_err() && check_ratio(&header, 0, bounds).is_err()
        );
    }

    #[test]
    fn the_counters_of_a_dwa_block_must_fit_its_pixels() {
        let header = header(Compression::DWAA(None), 256);
        let bounds = IntegerBounds::from_dimensions(Vec2(256, 256));
        let block = |counter: u64| {
            [2_u64, 0, 0, 9, 9, 0, 0, 0, counter, 9, 0].map(u64::to_le_bytes).concat()
        };
        assert!(check_dwa(&header, &block(256 * 256 * 3), bounds).is_ok());
        assert!(check_dwa(&header, &block(1 << 40), bounds).is_err());
        assert!(check_dwa(&header, &block(9)[..80], bounds).is_err());
    }
}

#[cfg(test)]
#[path = "guard_properties.rs"]
mod properties;
