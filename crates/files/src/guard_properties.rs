//! Checks of headers and blocks, on arbitrary claims.

use ::exr::prelude::Vec2;
use proptest::prelude::{Strategy, any, prop, prop_assert, prop_assert_eq, proptest};

use super::tests::header;
use super::*;

/// Sides of every order of magnitude.
fn sides() -> impl Strategy<Value = usize> {
    (0_u32..31).prop_flat_map(|bits| 1..=1_usize << bits)
}

proptest! {
    #[test]
    fn a_size_passes_just_if_its_product_is_within_the_limit(
        long in (any::<u64>(), any::<u64>()), short in (0_u64..300, 0_u64..300),
        pixels in 1_u64..1 << 20,
    ) {
        for (width, height) in [long, short, (long.0, short.1), (short.0, long.1)] {
            let product = u128::from(width) * u128::from(height);
            let fits = (1..=u128::from(pixels)).contains(&product);
            let found = Limits { pixels }.check_size(width, height).is_ok();
            prop_assert_eq!(found, fits, "{}×{} of {}", width, height, pixels);
        }
    }

    /// The checks of blocks compute with what the check of the part accepted.
    #[test]
    fn what_passes_is_within_the_limit_and_overflows_nowhere(
        size in (sides(), sides()), tile in (sides(), sides()), stored in any::<usize>(),
        counters in prop::collection::vec(any::<u64>(), 0..12), dwa in any::<bool>(),
    ) {
        let compression = if dwa { Compression::DWAB(None) } else { Compression::PIZ };
        let mut header = header(compression, 256);
        header.layer_size = Vec2(size.0, size.1);
        if let BlockDescription::Tiles(tiles) = &mut header.blocks {
            tiles.tile_size = Vec2(tile.0, tile.1);
        }
        let limits = Limits::default();
        if check_part(&header, limits).is_ok() {
            let block = (size.0.min(tile.0) * size.1.min(tile.1)) as u64 * 6;
            prop_assert!(block <= limits.block_bytes());
            let bounds = Vec2(size.0.min(tile.0), size.1.min(tile.1));
            let bounds = IntegerBounds::from_dimensions(bounds);
            let held = u128::from(block) <= stored as u128 * most_unpacked_per_byte(compression);
            prop_assert_eq!(check_ratio(&header, stored, bounds).is_ok(), held);
            let packed: Vec<u8> = counters.iter().flat_map(|c| c.to_le_bytes()).collect();
            let plausible = check_dwa(&header, &packed, bounds).is_ok();
            let raw = packed.len() as u64 == block;
            prop_assert!(!dwa || !plausible || raw || counters.len() >= DWA_COUNTERS);
        }
    }
}
