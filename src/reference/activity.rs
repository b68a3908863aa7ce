//! The blocks of an image that a network must process, and the distance of the others from them.

use crate::image::{Image, Rect};

/// Pixels per side of a block.
const BLOCK: usize = 16;
/// The distance if no active block is within the radius.
const FAR: u32 = 255;
/// Layer `m` of the map has one value for `2^m × 2^m` blocks.
const LAYERS: u32 = 5;

/// The clean blocks of a tile, and the distances to active ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Activity {
    /// Whether each block is clean, row by row.
    pub clean: Vec<bool>,
    /// The map's layers, each with its rows of distances.
    pub map: Vec<Vec<Vec<u32>>>,
}

/// A tile of an image.
#[derive(Clone, Copy, Debug)]
pub struct TileOfImage {
    /// First pixel of the tile.
    pub origin: [u32; 2],
    /// Columns and rows; multiples of 16.
    pub size: [u32; 2],
    /// The image's pixels that the tile stores.
    pub stores: Rect,
}

/// Classifies the blocks of a tile.
///
/// A block is clean if it and all blocks up to `constant_radius` away, counting diagonal steps,
/// have exactly the same finite color in all pixels. Only blocks within the tile and pixels within
/// the image count. Zeros of either sign are the same. Without a radius, no block is clean. A block
/// is active if it is not clean and has pixels that the tile stores.
///
/// The map's first layer holds the distance from each block to the nearest active one, counting
/// diagonal steps, or 255 if it exceeds `radius`. Layer `m` holds the minimum over `2^m × 2^m`
/// blocks.
#[must_use]
pub fn activity(
    color: &Image,
    tile: &TileOfImage,
    radius: u32,
    constant_radius: Option<u32>,
) -> Activity {
    let [columns, rows] = tile.size.map(|side| side as usize / BLOCK);
    let blocks = || (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
    let pixels: Vec<_> = blocks().map(|block| pixels(color, tile, block)).collect();
    let is_clean = |block: [usize; 2]| {
        let near = |reach| blocks().zip(&pixels).filter(move |(b, _)| steps(block, *b) <= reach);
        constant_radius.is_some_and(|reach| is_constant(near(reach).flat_map(|(_, pixels)| pixels)))
    };
    let exists = |[x, y]: [usize; 2]| !pixels[y * columns + x].is_empty();
    let clean: Vec<bool> = blocks().map(|block| exists(block) && is_clean(block)).collect();
    let is_active = |&[x, y]: &[usize; 2]| !clean[y * columns + x] && stores(tile, [x, y]);
    let active: Vec<_> = blocks().filter(is_active).collect();
    let distances = (0..rows)
        .map(|y| (0..columns).map(|x| distance([x, y], &active, radius)).collect::<Vec<_>>())
        .collect::<Vec<_>>();
    Activity { map: (0..LAYERS).map(|layer| least(&distances, 1 << layer)).collect(), clean }
}

/// Whether all pixels are finite and equal.
fn is_constant<'a>(pixels: impl Iterator<Item = &'a [f32; 3]>) -> bool {
    let mut first = None;
    pixels.into_iter().all(|pixel| *pixel == **first.get_or_insert(pixel))
        && first.is_some_and(|pixel| pixel.iter().all(|v| v.is_finite()))
}

/// A block's pixels inside the image.
fn pixels(image: &Image, tile: &TileOfImage, block: [usize; 2]) -> Vec<[f32; 3]> {
    let [left, top] = first(tile, block);
    let rows = (top..top + BLOCK).take_while(|&y| y < image.height() as usize);
    let end = (left + BLOCK).min(image.width() as usize);
    rows.flat_map(|y| image.row(y as u32)[left.min(end)..end].to_vec()).collect()
}

/// A block's first pixel in the image.
fn first(tile: &TileOfImage, block: [usize; 2]) -> [usize; 2] {
    [0, 1].map(|axis| tile.origin[axis] as usize + block[axis] * BLOCK)
}

fn stores(tile: &TileOfImage, block: [usize; 2]) -> bool {
    let first = first(tile, block);
    (0..2).all(|axis| {
        let stored = tile.stores.begin[axis] as usize..tile.stores.end[axis] as usize;
        (first[axis]..first[axis] + BLOCK).any(|pixel| stored.contains(&pixel))
    })
}

/// The number of steps from one block to another, counting diagonal ones.
fn steps(a: [usize; 2], b: [usize; 2]) -> u32 {
    a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])) as u32
}

fn distance(from: [usize; 2], active: &[[usize; 2]], radius: u32) -> u32 {
    active.iter().map(|&block| steps(from, block)).filter(|&d| d <= radius).min().unwrap_or(FAR)
}

/// The minimum of each square of `side` × `side` blocks.
fn least(distances: &[Vec<u32>], side: usize) -> Vec<Vec<u32>> {
    let of_rows = |rows: &[Vec<u32>]| {
        let columns = 0..rows[0].len().div_ceil(side);
        let square = |x| rows.iter().flat_map(move |row| row.iter().skip(x * side).take(side));
        columns.map(|x| *square(x).min().expect("a square has blocks")).collect()
    };
    distances.chunks(side).map(of_rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
        Image::new(width, height, pixels).expect("a valid image")
    }

    /// An image as a single tile, with a radius of 2 blocks.
    fn whole(image: &Image, constant_radius: u32) -> Activity {
        let (width, height) = image.size();
        let stores = Rect { begin: [0, 0], end: [width, height] };
        let size = [width, height].map(|side| side.next_multiple_of(16));
        let tile = TileOfImage { origin: [0, 0], size, stores };
        activity(image, &tile, 2, Some(constant_radius))
    }

    #[test]
    fn what_is_constant_is_clean_and_far_from_anything_active() {
        for color in [[0.0, 3.0, 1e9], [-1.0; 3], [1e-42; 3], [f32::MAX; 3]] {
            let found = whole(&image(40, 20, |_, _| color), 3);
            assert_eq!(found.clean, [true; 6]);
            assert_eq!(found.map[0], [[FAR; 3], [FAR; 3]]);
            assert_eq!(found.map[1], [[FAR; 2]]);
            assert_eq!(found.map[4], [[FAR]]);
        }
        for (width, height) in [(3, 3), (2, 16), (16, 1), (1, 2), (1, 1)] {
            assert_eq!(whole(&image(width, height, |_, _| [0.5; 3]), 3).clean, [true]);
        }
    }

    #[test]
    fn what_is_not_finite_is_not_clean() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(whole(&image(16, 16, |_, _| [0.5, bad, 0.5]), 0).clean, [false], "{bad}");
        }
    }

    #[test]
    fn zeros_of_either_sign_are_the_same() {
        let zeros = image(40, 20, |x, y| [[0.0, -0.0][(x + y) as usize % 2]; 3]);
        assert_eq!(whole(&zeros, 3).clean, [true; 6]);
    }

    #[test]
    fn the_smallest_difference_anywhere_in_a_block_counts() {
        for place in [(0, 0), (15, 0), (7, 15), (15, 15)] {
            let next = |x, y| [0.5, 0.5, if (x, y) == place { 0.5_f32.next_up() } else { 0.5 }];
            assert_eq!(whole(&image(16, 16, next), 0).clean, [false], "{place:?}");
        }
    }

    #[test]
    fn a_pixel_keeps_all_blocks_within_the_radius_from_being_clean() {
        let spot = image(160, 80, |x, y| [if (x, y) == (33, 70) { 9.0 } else { 1.0 }; 3]);
        for radius in 0..4 {
            let found = whole(&spot, radius).clean;
            let near = |i: usize| steps([i % 10, i / 10], [2, 4]) <= radius;
            let expected: Vec<_> = (0..50).map(|i| !near(i)).collect();
            assert_eq!(found, expected, "{radius}");
        }
    }

    #[test]
    fn constant_blocks_of_another_color_are_not_clean_together() {
        let jump = image(96, 16, |x, _| [if x < 48 { 1.0 } else { 2.0 }; 3]);
        assert_eq!(whole(&jump, 0).clean, [true; 6]);
        assert_eq!(whole(&jump, 1).clean, [true, true, false, false, true, true]);
    }

    #[test]
    fn a_bright_pixel_makes_its_block_active_and_the_distances_grow_from_there() {
        let bright = |x, y| if (x, y) == (31, 0) { [9.0; 3] } else { [1.0; 3] };
        let found = whole(&image(96, 48, bright), 0);
        assert_eq!(found.clean.iter().position(|clean| !clean), Some(1));
        let row = [1, 0, 1, 2, FAR, FAR];
        assert_eq!(found.map[0], [row, [1, 1, 1, 2, FAR, FAR], [2, 2, 2, 2, FAR, FAR]]);
        assert_eq!(found.map[1], [[0, 1, FAR], [2, 2, FAR]]);
        assert_eq!(found.map[2], [[0, FAR]]);
    }

    #[test]
    fn only_blocks_that_the_tile_stores_are_active() {
        let noise = image(100, 64, |x, y| [((x * 7 + y * 5) % 11) as f32; 3]);
        let stores = Rect { begin: [48, 16], end: [65, 32] };
        let tile = TileOfImage { origin: [16, 0], size: [80, 64], stores };
        for constant_radius in [Some(0), None] {
            let found = activity(&noise, &tile, 1, constant_radius);
            assert_eq!(found.clean, [false; 20]);
            let near = [FAR, 1, 1, 1, 1];
            assert_eq!(found.map[0], [near, [FAR, 1, 0, 0, 1], near, [FAR; 5]]);
        }
    }

    #[test]
    fn blocks_outside_the_tile_do_not_count() {
        let noisy_left = image(64, 16, |x, _| [if x < 16 { x as f32 } else { 1.0 }; 3]);
        let stores = Rect { begin: [16, 0], end: [64, 16] };
        let tile = TileOfImage { origin: [16, 0], size: [64, 16], stores };
        assert_eq!(activity(&noisy_left, &tile, 1, Some(3)).clean, [true, true, true, false]);
    }
}
