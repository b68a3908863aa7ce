//! The blocks of an image that a network must work on, and the distance of the others from those.

use super::input_process::encode_color;
use super::repair::repair;
use crate::image::{Image, Rect};
use crate::model::{Encoding, TransferFunction};

/// Pixels per side of a block.
const BLOCK: usize = 16;
/// The largest second difference in a clean block, in encoded values.
pub const BEND: f64 = 1.0 / 1024.0;
/// A block is dark if its first pixel, times the input scale, is at most this.
pub const DARK: f64 = 2e-6;
/// The distance if no active block is within the radius.
const FAR: u32 = 255;
/// Layer `m` of the map has one value for `2^m × 2^m` blocks.
const LAYERS: u32 = 5;

/// The findings about a tile's blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Activity {
    /// Whether each block is clean, row by row.
    pub clean: Vec<bool>,
    /// The map's layers, each with its rows of distances.
    pub map: Vec<Vec<Vec<u32>>>,
}

/// The images of one view, all the same size.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Linear color.
    pub color: &'a Image,
    /// Linear albedo in `[0, 1]`.
    pub albedo: Option<&'a Image>,
    /// Normal with components in `[−1, 1]`.
    pub normal: Option<&'a Image>,
}

/// A tile of a view.
#[derive(Clone, Copy, Debug)]
pub struct TileOfView {
    /// First pixel of the tile.
    pub origin: [u32; 2],
    /// Columns and rows; multiples of 16.
    pub size: [u32; 2],
    /// The view's pixels that the tile stores.
    pub stores: Rect,
}

/// Encodes color for the comparison.
#[derive(Clone, Copy)]
struct Light {
    encoding: Encoding,
    input_scale: f32,
}

impl Light {
    /// Encodes a value as the network sees it, except that light always uses PU, in which equal
    /// steps look about equally large.
    fn encode(self, v: f32) -> f64 {
        let transfer_function = match self.encoding.transfer_function {
            TransferFunction::Pu | TransferFunction::Log => TransferFunction::Pu,
            other => other,
        };
        encode_color(Encoding { transfer_function, ..self.encoding }, v, self.input_scale)
    }
}

/// A block judged on its own.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BlockKind {
    Noisy,
    Dark,
    Clean,
}

/// The blocks of a tile of `size` pixels, width first, a multiple of 16, in an image.
///
/// A block is even if its pixels, [repaired](repair), are all equal; or if it has at least three
/// pixels in both directions and no second difference along rows and columns exceeds 1/1024 in any
/// channel, once encoded for the network, with light encoded by PU. If the image ends inside the
/// block, the block is taken to begin earlier, so that it has three pixels a side if the image has
/// them. An image of one or two pixels is even.
///
/// Even blocks are clean, unless they are dark: no channel of the first pixel, times the scale,
/// exceeds 2e-6. A dark block may be a surface that no path has lit yet. It is clean if albedo or
/// normal is given and every given one is zero there, or if none of the eight blocks around it,
/// within the tile and the image, is noisy, that is, not even. A block is active if it is not clean
/// and has pixels that the tile stores. Without `skip`, all blocks are noisy.
///
/// The map's first layer holds the distance from each block to the nearest active one, counting
/// diagonal steps, or 255 if it exceeds `radius`. Layer `m` holds the minimum over `2^m × 2^m`
/// blocks.
#[must_use]
pub fn activity(
    view: &View<'_>,
    encoding: Encoding,
    input_scale: f32,
    tile: &TileOfView,
    radius: u32,
    skip: bool,
) -> Activity {
    let [columns, rows] = tile.size.map(|side| side as usize / BLOCK);
    let blocks = || (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
    let light = Light { encoding, input_scale };
    let repaired = repair(view.color, input_scale);
    let view = View { color: &repaired, ..*view };
    let kind = |block| if skip { kind(&view, tile, block, light) } else { BlockKind::Noisy };
    let in_image = |block: &[usize; 2]| !pixels(view.color, tile, *block).is_empty();
    let kinds: Vec<_> = blocks().filter(in_image).map(|block| (block, kind(block))).collect();
    let is_clean = |block| is_clean(&kinds, block);
    let clean: Vec<bool> = blocks().map(is_clean).collect();
    let is_active = |&[x, y]: &[usize; 2]| !clean[y * columns + x] && stores(tile, [x, y]);
    let active: Vec<_> = blocks().filter(is_active).collect();
    let distances = (0..rows)
        .map(|y| (0..columns).map(|x| distance([x, y], &active, radius)).collect::<Vec<_>>())
        .collect::<Vec<_>>();
    Activity { map: (0..LAYERS).map(|layer| least(&distances, 1 << layer)).collect(), clean }
}

/// Whether a block is clean, given all blocks inside the image.
fn is_clean(kinds: &[([usize; 2], BlockKind)], block: [usize; 2]) -> bool {
    let is_near = |other: [usize; 2]| (0..2).all(|axis| other[axis].abs_diff(block[axis]) <= 1);
    match kinds.iter().find(|(other, _)| *other == block) {
        None | Some((_, BlockKind::Noisy)) => false,
        Some((_, BlockKind::Clean)) => true,
        Some((_, BlockKind::Dark)) => {
            kinds.iter().all(|&(other, kind)| kind != BlockKind::Noisy || !is_near(other))
        }
    }
}

/// The rows of a block's pixels inside the image, extended to at least three rows of three pixels
/// if the image is large enough and the block has any.
fn pixels(image: &Image, tile: &TileOfView, block: [usize; 2]) -> Vec<Vec<[f32; 3]>> {
    let [left, top] = first(tile, block);
    let (width, height) = (image.width() as usize, image.height() as usize);
    if left >= width || top >= height {
        return Vec::new();
    }
    let range = |first: usize, side: usize| {
        let end = (first + BLOCK).min(side);
        first.min(end.saturating_sub(3))..end
    };
    range(top, height).map(|y| image.row(y as u32)[range(left, width)].to_vec()).collect()
}

/// A block's first pixel in the image.
fn first(tile: &TileOfView, block: [usize; 2]) -> [usize; 2] {
    [0, 1].map(|axis| tile.origin[axis] as usize + block[axis] * BLOCK)
}

fn stores(tile: &TileOfView, block: [usize; 2]) -> bool {
    let first = first(tile, block);
    (0..2).all(|axis| {
        let stored = tile.stores.begin[axis] as usize..tile.stores.end[axis] as usize;
        (first[axis]..first[axis] + BLOCK).any(|pixel| stored.contains(&pixel))
    })
}

fn kind(view: &View<'_>, tile: &TileOfView, block: [usize; 2], light: Light) -> BlockKind {
    let rows = pixels(view.color, tile, block);
    let (width, height) = (rows[0].len(), rows.len());
    let wide = width >= 3 && height >= 3;
    let even = width * height < 3 || same(&rows) || wide && !bends(&rows, light);
    let dark = || rows[0][0].iter().all(|&v| f64::from(v) * f64::from(light.input_scale) <= DARK);
    match even {
        false => BlockKind::Noisy,
        true if dark() && !is_empty(view, tile, block) => BlockKind::Dark,
        true => BlockKind::Clean,
    }
}

/// Whether albedo and normal, if given, show no surface.
fn is_empty(view: &View<'_>, tile: &TileOfView, block: [usize; 2]) -> bool {
    let given: Vec<_> = [view.albedo, view.normal].into_iter().flatten().collect();
    let zero = |image: &Image| pixels(image, tile, block).iter().flatten().all(|p| *p == [0.0; 3]);
    !given.is_empty() && given.into_iter().all(zero)
}

fn same(rows: &[Vec<[f32; 3]>]) -> bool {
    rows.iter().flatten().all(|pixel| *pixel == rows[0][0])
}

fn bends(rows: &[Vec<[f32; 3]>], light: Light) -> bool {
    let v = |x: usize, y: usize, c: usize| light.encode(rows[y][x][c]);
    let (width, height) = (rows[0].len(), rows.len());
    let along_rows = |y: usize, c: usize| {
        (2..width).any(|x| (v(x - 2, y, c) - 2.0 * v(x - 1, y, c) + v(x, y, c)).abs() > BEND)
    };
    let along_columns = |x: usize, c: usize| {
        (2..height).any(|y| (v(x, y - 2, c) - 2.0 * v(x, y - 1, c) + v(x, y, c)).abs() > BEND)
    };
    (0..3).any(|c| (0..height).any(|y| along_rows(y, c)) || (0..width).any(|x| along_columns(x, c)))
}

fn distance(from: [usize; 2], active: &[[usize; 2]], radius: u32) -> u32 {
    let to = |b: &[usize; 2]| from[0].abs_diff(b[0]).max(from[1].abs_diff(b[1])) as u32;
    active.iter().map(to).filter(|&d| d <= radius).min().unwrap_or(FAR)
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
    use crate::reference::pu_inverse;

    fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
        Image::new(width, height, pixels).expect("a valid image")
    }

    fn color(color: &Image) -> View<'_> {
        View { color, albedo: None, normal: None }
    }

    #[test]
    fn what_is_dark_beside_noise_is_clean_where_albedo_and_normal_say_that_nothing_is_there() {
        let black = image(32, 16, |x, _| [[0.0, -0.0][x as usize % 2]; 3]);
        let color = image(32, 16, |x, y| [[0.0, 1.0][usize::from((x, y) == (20, 3))]; 3]);
        let surface = image(32, 16, |x, y| [0.0, [0.0, 0.6][usize::from((x, y) == (9, 15))], 0.0]);
        let stores = Rect { begin: [0, 0], end: [32, 16] };
        let tile = TileOfView { origin: [0, 0], size: [32, 16], stores };
        for (albedo, normal, clean) in [
            (None, None, false),
            (Some(&black), None, true),
            (None, Some(&black), true),
            (Some(&black), Some(&black), true),
            (Some(&surface), None, false),
            (Some(&black), Some(&surface), false),
        ] {
            let view = View { albedo, normal, color: &color };
            let found = activity(&view, Encoding::default(), 1.0, &tile, 2, true).clean;
            assert_eq!(found, [clean, false]);
        }
    }

    #[test]
    fn what_is_dark_is_clean_where_nothing_around_it_is_noisy() {
        let lit = image(80, 32, |x, y| [[0.0, 1.0][usize::from((x, y) == (3, 30))]; 3]);
        let row = [false, false, true, true, true];
        assert_eq!(whole(&lit).clean, [row, row].concat());
        for black in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(whole(&image(40, 20, |_, _| [black; 3])).clean, [true; 6], "{black}");
        }
    }

    /// An image as a single tile, with a radius of 2 blocks.
    fn whole(image: &Image) -> Activity {
        let (width, height) = image.size();
        let stores = Rect { begin: [0, 0], end: [width, height] };
        let size = [width, height].map(|side| side.next_multiple_of(16));
        let tile = TileOfView { origin: [0, 0], size, stores };
        activity(&color(image), Encoding::default(), 1.0, &tile, 2, true)
    }

    #[test]
    fn what_is_constant_is_clean_and_far_from_anything_active() {
        let found = whole(&image(40, 20, |_, _| [0.0, 3.0, 1e9]));
        assert_eq!(found.clean, [true; 6]);
        assert_eq!(found.map[0], [[FAR; 3], [FAR; 3]]);
        assert_eq!(found.map[1], [[FAR; 2]]);
        assert_eq!(found.map[4], [[FAR]]);
    }

    #[test]
    fn a_bright_pixel_makes_its_block_active_and_the_distances_grow_from_there() {
        let bright = |x, y| if (x, y) == (31, 0) { [9.0; 3] } else { [1.0; 3] };
        let found = whole(&image(96, 48, bright));
        assert_eq!(found.clean.iter().position(|clean| !clean), Some(1));
        let row = [1, 0, 1, 2, FAR, FAR];
        assert_eq!(found.map[0], [row, [1, 1, 1, 2, FAR, FAR], [2, 2, 2, 2, FAR, FAR]]);
        assert_eq!(found.map[1], [[0, 1, FAR], [2, 2, FAR]]);
        assert_eq!(found.map[2], [[0, FAR]]);
    }

    #[test]
    fn a_block_may_bend_by_the_threshold_along_either_axis() {
        let bent = |c: f64, x: u32| [pu_inverse(0.3 + c / 2.0 * f64::from(x * x)) as f32; 3];
        for (c, clean) in [(0.99 * BEND, true), (1.01 * BEND, false)] {
            assert_eq!(whole(&image(16, 16, |x, _| bent(c, x))).clean, [clean], "rows, {c}");
            assert_eq!(whole(&image(16, 16, |_, y| bent(c, y))).clean, [clean], "columns, {c}");
        }
    }

    #[test]
    fn the_edges_of_blocks_may_jump() {
        let found = whole(&image(32, 32, |x, y| [(1 + x / 16 + 7 * (y / 16)) as f32; 3]));
        assert_eq!(found.clean, [true; 4]);
    }

    #[test]
    fn a_bad_pixel_in_a_clean_block_is_filled_but_an_outlier_and_a_negative_value_are_noise() {
        for (value, clean) in
            [(f32::NAN, true), (f32::INFINITY, true), (-1.0, false), (1e30, false)]
        {
            let spot = |x, y| if (x, y) == (3, 15) { [0.5, value, 0.5] } else { [0.5; 3] };
            assert_eq!(whole(&image(16, 16, spot)).clean, [clean], "{value}");
        }
    }

    #[test]
    fn narrow_images_must_be_constant_and_two_pixels_are_left_alone() {
        let ramp = |x: u32, y: u32| [0.5 + 1e-6 * (x + y) as f32; 3];
        for (width, height, slope) in
            [(3, 3, true), (2, 16, false), (16, 1, false), (1, 2, true), (1, 1, true)]
        {
            let name = format!("{width}×{height}");
            assert_eq!(whole(&image(width, height, |_, _| [0.5; 3])).clean, [true], "{name}");
            assert_eq!(whole(&image(width, height, ramp)).clean, [slope], "{name}");
        }
    }

    #[test]
    fn where_a_block_has_fewer_than_three_pixels_a_side_those_before_it_count() {
        let last =
            |steps| image(17, 17, move |x, _| [0.5 + 0.1 * (x.max(15) - 15) as f32 * steps; 3]);
        assert_eq!(whole(&last(0.0)).clean, [true; 4]);
        assert_eq!(whole(&last(1.0)).clean, [true, false, true, false]);
    }

    #[test]
    fn only_blocks_that_the_tile_stores_are_active() {
        let noise = image(100, 64, |x, y| [((x * 7 + y * 5) % 11) as f32; 3]);
        let stores = Rect { begin: [48, 16], end: [65, 32] };
        let tile = TileOfView { origin: [16, 0], size: [80, 64], stores };
        for skip in [true, false] {
            let found = activity(&color(&noise), Encoding::default(), 1.0, &tile, 1, skip);
            assert_eq!(found.clean, [false; 20]);
            let near = [FAR, 1, 1, 1, 1];
            assert_eq!(found.map[0], [near, [FAR, 1, 0, 0, 1], near, [FAR; 5]]);
        }
    }
}
