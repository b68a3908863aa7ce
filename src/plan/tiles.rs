//! Cuts an image into tiles that overlap by the receptive field.

use crate::image::Rect;

/// Longest side of an image, so that no kernel's arithmetic exceeds 32 bits.
pub const MAX_SIDE: u32 = 1 << 16;

/// The constraints on tiles.
#[derive(Clone, Copy, Debug)]
pub struct Constraints {
    /// A divisor of every tile's corner and size.
    pub alignment: u32,
    /// Overlap on each side with a neighbor; see [`super::halo::halo`].
    pub halo: u32,
    /// Largest side of a tile.
    pub max_side: u32,
    /// Maximum pixels of a tile.
    pub max_pixels: u64,
}

/// Maximum multiply-accumulates of one dispatch when a display or a watchdog waits for it: 0.2 s at
/// 0.5 TFLOP/s, and at 0.05 TFLOP/s the 2 s after which Windows resets an unresponsive GPU.
pub const MACS_PER_DISPATCH: f64 = 50e9;

impl Constraints {
    /// Adds a limit that keeps a tile's largest layer, of `macs_per_pixel` multiply-accumulates per
    /// pixel, within [`MACS_PER_DISPATCH`]. The smallest tile cannot be divided and stays allowed.
    #[must_use]
    pub fn with_short_dispatches(self, macs_per_pixel: f64) -> Self {
        let smallest = u64::from(2 * self.halo + self.alignment).pow(2);
        let short = (MACS_PER_DISPATCH / macs_per_pixel) as u64;
        Self { max_pixels: self.max_pixels.min(short.max(smallest)), ..self }
    }
}

/// Equal-sized tiles that cover an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TilePlan {
    /// Size of every tile including overlap, width first; a multiple of the alignment.
    pub tile: [u32; 2],
    /// The tiles, row by row.
    pub tiles: Vec<PlacedTile>,
}

/// One tile of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacedTile {
    /// The tile's first pixel in the image. The tile may extend past the image's right and bottom
    /// edges by less than the alignment.
    pub origin: [u32; 2],
    /// The image pixels that this tile stores.
    pub stores: Rect,
}

impl TilePlan {
    /// The plan that processes the fewest pixels, overlap included; `None` if even the smallest
    /// tile violates a constraint.
    #[must_use]
    #[doc(hidden)]
    pub fn new(size: [u32; 2], constraints: &Constraints) -> Option<Self> {
        let candidates = size.map(|side| candidates(side, constraints));
        let pairs = candidates[0].iter().flat_map(|x| candidates[1].iter().map(move |y| [x, y]));
        let fits = |[x, y]: &[&Candidate; 2]| {
            x.side.max(y.side) <= constraints.max_side
                && area([x.side, y.side]) <= constraints.max_pixels
        };
        // Fewest pixels, overlap included; fewest tiles break ties.
        let cost = |[x, y]: &[&Candidate; 2]| {
            let count = x.count * y.count;
            (count * area([x.side, y.side]), count)
        };
        let [x, y] = pairs.filter(fits).min_by_key(cost)?;
        Some(Self::with_tile(size, [x.side, y.side], constraints))
    }

    /// The plan with tiles of this size. Each side must be a multiple of the alignment, and either
    /// cover the image or leave pixels between the overlaps.
    fn with_tile(size: [u32; 2], tile: [u32; 2], constraints: &Constraints) -> Self {
        let axes = [0, 1].map(|axis| spans(size[axis], tile[axis], constraints));
        let place = |y: &Span, x: &Span| PlacedTile {
            origin: [x.origin, y.origin],
            stores: Rect { begin: [x.begin, y.begin], end: [x.end, y.end] },
        };
        let tiles = axes[1].iter().flat_map(|y| axes[0].iter().map(move |x| place(y, x))).collect();
        Self { tile, tiles }
    }
}

struct Span {
    origin: u32,
    begin: u32,
    end: u32,
}

fn area(tile: [u32; 2]) -> u64 {
    u64::from(tile[0]) * u64::from(tile[1])
}

/// A tile side, and the number of such tiles along that axis of the image.
struct Candidate {
    side: u32,
    count: u64,
}

/// Tile sides worth trying: the whole image, and the smallest side for every tile count.
fn candidates(size: u32, constraints: &Constraints) -> Vec<Candidate> {
    let Constraints { alignment, halo, .. } = *constraints;
    let padded = size.next_multiple_of(alignment);
    let inner = padded.saturating_sub(2 * halo);
    let mut sides = vec![padded];
    let side = |count| inner.div_ceil(count).next_multiple_of(alignment) + 2 * halo;
    sides.extend((2..=inner / alignment).map(side));
    sides.dedup();
    let count = |side| starts(size, side, constraints).len() as u64;
    sides.into_iter().map(|side| Candidate { side, count: count(side) }).collect()
}

/// First pixels of the tiles along an axis. The last tile ends where the padded image does.
fn starts(size: u32, tile: u32, constraints: &Constraints) -> Vec<u32> {
    let last = size.next_multiple_of(constraints.alignment).saturating_sub(tile);
    let step = tile.saturating_sub(2 * constraints.halo).max(constraints.alignment);
    (0..last).step_by(step as usize).chain([last]).collect()
}

/// Each tile stores from where the previous one stopped to the start of its own overlap.
fn spans(size: u32, tile: u32, constraints: &Constraints) -> Vec<Span> {
    let starts = starts(size, tile, constraints);
    let mut begin = 0;
    let span = |(i, &origin): (usize, &u32)| {
        let end = if i + 1 == starts.len() { size } else { origin + tile - constraints.halo };
        let span = Span { origin, begin, end };
        begin = end;
        span
    };
    starts.iter().enumerate().map(span).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::macs::largest_layer_macs_per_pixel;
    use crate::model::{Network, Quality, Weights, fuse::Fused};
    use crate::plan::halo::halo;

    fn constraints(alignment: u32, halo: u32, max_side: u32) -> Constraints {
        Constraints { alignment, halo, max_side, max_pixels: u64::MAX }
    }

    #[test]
    fn an_image_that_fits_is_one_tile() {
        let plan = TilePlan::new([1000, 17], &constraints(16, 96, 4096)).unwrap();
        assert_eq!((plan.tile, plan.tiles.len()), ([1008, 32], 1));
        assert_eq!(plan.tiles[0].stores, Rect { begin: [0, 0], end: [1000, 17] });
    }

    #[test]
    fn the_largest_image_is_planned_within_its_constraints() {
        let limits = Constraints { max_pixels: 2_000_000, ..constraints(16, 96, 8192) };
        let plan = TilePlan::new([16384, 16384], &limits).unwrap();
        assert!(area(plan.tile) <= 2_000_000 && plan.tiles.len() > 100, "{:?}", plan.tile);
        // Overlap adds less than half of the image's own cost.
        assert!(plan.tiles.len() as u64 * area(plan.tile) < 16384 * 16384 * 3 / 2);
    }

    #[test]
    fn tiles_smaller_than_twice_the_overlap_are_refused() {
        assert_eq!(TilePlan::new([1000, 1000], &constraints(16, 96, 192)), None);
    }

    /// The plan for an adapter with memory for any tile, and its largest dispatch.
    fn short(network: &Network, size: [u32; 2]) -> (TilePlan, f64) {
        let macs = largest_layer_macs_per_pixel(network);
        let limits = constraints(16, halo(network), 16384).with_short_dispatches(macs);
        let plan = TilePlan::new(size, &limits).unwrap();
        let largest = area(plan.tile) as f64 * macs;
        (plan, largest)
    }

    #[test]
    fn no_dispatch_of_the_built_in_weights_is_longer_than_the_bound() {
        for (quality, size, tiles) in [
            (Quality::Fast, [3840, 2160], 1),
            (Quality::Fast, [7680, 4320], 1),
            (Quality::Balanced, [3840, 2160], 1),
            (Quality::Balanced, [7680, 4320], 4),
            (Quality::High, [1920, 1080], 1),
            (Quality::High, [3840, 2160], 2),
            (Quality::High, [7680, 4320], 8),
        ] {
            let weights = Weights::builtin(quality).unwrap();
            let (fused, plain) = (Fused::new(&weights, 16).network, weights.network().clone());
            assert!(short(&plain, size).1 <= MACS_PER_DISPATCH, "{quality:?} {size:?}, plain");
            let (plan, largest) = short(&fused, size);
            assert!(largest <= MACS_PER_DISPATCH, "{quality:?} {size:?}: {largest}");
            assert_eq!(plan.tiles.len(), tiles, "{quality:?} {size:?}: {:?}", plan.tile);
        }
    }

    #[test]
    fn the_smallest_tile_is_accepted_however_long_its_dispatches_are() {
        let huge = Network::unet(9, &[2048, 2048, 2048, 2048, 2048]);
        let (plan, largest) = short(&huge, [1000, 1000]);
        assert!(plan.tile == [208, 208] && largest > MACS_PER_DISPATCH, "{plan:?}");
        let memory = Constraints { max_pixels: 208 * 208 - 1, ..constraints(16, 96, 16384) };
        assert_eq!(TilePlan::new([1000, 1000], &memory.with_short_dispatches(1.0)), None);
    }
}
