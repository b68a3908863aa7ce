//! Replaces pixels that no network should see: see [`fill`] and [`repair`].

use crate::image::Image;
use crate::model::{Encoding, TransferFunction};

/// The luminance of middle gray: the image's average, times the input scale.
pub const GREY: f64 = 0.18;
/// Values are clamped to ± this, so that no sum or quotient exceeds 32 bits.
pub const MOST: f32 = 1e30;
/// Fewer infinite pixels together are fireflies.
const SUN: usize = 4;
/// A counted +∞ is at least this bright: the largest 16-bit float, which most renderers' files
/// cannot exceed.
const LARGEST_F16: f32 = 65504.0;

/// Color that a network can read.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaired {
    /// Linear color, finite everywhere.
    pub color: Image,
    /// Row by row, whether the pixel has a color: whether it or one within two pixels is good.
    pub valid: Vec<bool>,
}

/// Fills bad pixels. A pixel that is not finite in all channels becomes the mean of the finite ones
/// among the eight around it, or else among the 24 around it, or else black. For the mean, values
/// are clamped to ±1e30.
#[must_use]
pub fn fill(image: &Image) -> Repaired {
    map(image, |place| filled(image, place, f32::INFINITY))
}

/// Repairs noisy color for the network, before exposure. In this order:
///
/// 1. If at least four of the 3×3 pixels around a pixel have +∞ in a channel, +∞ stands, in this
///    and the other steps, for the largest finite value of any channel among the 5×5 pixels, but at
///    least 65504. Fewer infinite pixels are fireflies.
/// 2. NaN, −∞ or any other +∞ in a channel makes a pixel missing, and it is filled as by [`fill`].
/// 3. All values are clamped to ±1e30, and negative ones to 0 where the luminance is negative.
/// 4. No pixel is brighter than `outlier` times the brightest good one of the eight around it or
///    `outlier` times middle gray, `0.18 / input_scale`, whichever is more; brighter pixels are
///    darkened to that limit, keeping their hue. For this, negative channels count as 0.
#[must_use]
pub fn repair(color: &Image, input_scale: f32, outlier: f64) -> Repaired {
    map(color, |place| {
        let infinite = infinity(color, place);
        let pixel = filled(color, place, infinite)?.map(|v| v.clamp(-MOST, MOST));
        let pixel = if luminance(pixel) < 0.0 { pixel.map(|v| v.max(0.0)) } else { pixel };
        let lights = around(color, place, 1, infinite).into_iter().map(light);
        let most = outlier * lights.fold(GREY / f64::from(input_scale), f64::max);
        let share = (most / light(pixel)).min(1.0);
        Some(if light(pixel) > most { pixel.map(|v| (f64::from(v) * share) as f32) } else { pixel })
    })
}

/// [`repair`], or only [`fill`] for data that is not light.
#[must_use]
pub fn repair_in(encoding: Encoding, color: &Image, input_scale: f32) -> Repaired {
    match encoding.transfer_function {
        TransferFunction::Signed => fill(color),
        _ => repair(color, input_scale, encoding.outlier()),
    }
}

/// The pixel, or the mean of good ones around it if there are any. +∞ stands for `infinite`.
fn filled(image: &Image, place: [i64; 2], infinite: f32) -> Option<[f32; 3]> {
    let pixel = image.row(place[1] as u32)[place[0] as usize];
    good(pixel, infinite).or_else(|| mean(image, place, infinite))
}

/// The mean of the good pixels around a pixel, if there are any.
fn mean(image: &Image, place: [i64; 2], infinite: f32) -> Option<[f32; 3]> {
    let rings = [1, 2].map(|distance| around(image, place, distance, infinite));
    let mean = |ring: &Vec<[f32; 3]>| {
        let sum = |c: usize| ring.iter().map(|p| f64::from(p[c])).sum::<f64>();
        [0, 1, 2].map(|c| (sum(c) / ring.len() as f64) as f32)
    };
    rings.iter().find(|ring| !ring.is_empty()).map(mean)
}

/// The replacement for a missing pixel of a layer: the mean of the layer's good pixels around it,
/// or else 0. +∞ stands for the same value as in the beauty.
pub(super) fn mean_around(layer: &Image, beauty: &Image, place: [i64; 2]) -> [f32; 3] {
    mean(layer, place, infinity(beauty, place)).unwrap_or_default()
}

/// A pixel of a layer, with +∞ replaced by the value it stands for in the beauty.
pub(super) fn substituted(layer: &Image, beauty: &Image, place: [i64; 2]) -> [f32; 3] {
    let infinite = infinity(beauty, place);
    let pixel = layer.row(place[1] as u32)[place[0] as usize];
    pixel.map(|v| if v == f32::INFINITY { infinite } else { v })
}

/// The pixel with `infinite` in place of +∞, if all its values are then finite.
fn good(pixel: [f32; 3], infinite: f32) -> Option<[f32; 3]> {
    let pixel = pixel.map(|v| if v == f32::INFINITY { infinite } else { v });
    is_finite(pixel).then_some(pixel)
}

/// The value that +∞ stands for at a pixel.
fn infinity(image: &Image, place: [i64; 2]) -> f32 {
    let near = window(image, place, 1).map(|[x, y]| image.row(y as u32)[x as usize]);
    if near.filter(|pixel| pixel.contains(&f32::INFINITY)).count() < SUN {
        return f32::INFINITY;
    }
    let values = window(image, place, 2).flat_map(|[x, y]| image.row(y as u32)[x as usize]);
    values.filter(|v| v.is_finite()).fold(LARGEST_F16, f32::max)
}

/// Luminance with values clamped to `[0, 1e30]`.
fn light(pixel: [f32; 3]) -> f64 {
    luminance(pixel.map(|v| v.clamp(0.0, MOST)))
}

/// Luminance of linear color with Rec. 709 primaries.
pub(super) fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.212_671 * f64::from(r) + 0.715_160 * f64::from(g) + 0.072_169 * f64::from(b)
}

pub(super) fn is_finite(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|v| v.is_finite())
}

fn map(image: &Image, pixel: impl Fn([i64; 2]) -> Option<[f32; 3]>) -> Repaired {
    let mut color = image.clone();
    let width = i64::from(image.width());
    let place = |i| [i % width, i / width];
    let found: Vec<_> = (0..).map(place).map(pixel).take(image.pixels().len()).collect();
    for (value, found) in color.pixels_mut().iter_mut().zip(&found) {
        *value = found.unwrap_or_default();
    }
    Repaired { color, valid: found.iter().map(Option::is_some).collect() }
}

/// The good pixels up to `distance` away, except the center, clamped to ±1e30.
fn around(image: &Image, place: [i64; 2], distance: i64, infinite: f32) -> Vec<[f32; 3]> {
    let others = window(image, place, distance).filter(|other| *other != place);
    let pixels = others.filter_map(|[x, y]| good(image.row(y as u32)[x as usize], infinite));
    pixels.map(|pixel| pixel.map(|v| v.clamp(-MOST, MOST))).collect()
}

/// The places in the image up to `distance` away, counting diagonal steps.
fn window(image: &Image, [x, y]: [i64; 2], distance: i64) -> impl Iterator<Item = [i64; 2]> {
    let (width, height) = (i64::from(image.width()), i64::from(image.height()));
    let steps = move || -distance..=distance;
    let places = steps().flat_map(move |dy| steps().map(move |dx| [x + dx, y + dy]));
    places.filter(move |[x, y]| (0..width).contains(x) && (0..height).contains(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: [f32; 3] = [0.5, f32::NAN, 0.5];

    fn row(values: &[f32]) -> Image {
        let pixels = values.iter().map(|&v| [v; 3]).collect();
        Image::new(values.len() as u32, 1, pixels).expect("a valid image")
    }

    #[test]
    fn a_bad_pixel_is_the_mean_of_its_finite_neighbors() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let found = fill(&row(&[9.0, 1.0, bad, 4.0, 9.0]));
            assert_eq!(found.color, row(&[9.0, 1.0, 2.5, 4.0, 9.0]));
            assert_eq!(fill(&row(&[bad, 3.0])).color, row(&[3.0, 3.0]));
        }
    }

    #[test]
    fn a_pixel_among_bad_ones_looks_two_pixels_far_and_then_is_black_and_not_valid() {
        let (bad, filled) = (f32::NAN, 6.0);
        for found in [fill, |image: &Image| repair(image, 1.0, 256.0)]
            .map(|f| f(&row(&[6.0, bad, bad, bad])))
        {
            assert_eq!(found.color, row(&[6.0, filled, filled, 0.0]));
            assert_eq!(found.valid, [true, true, true, false]);
        }
        assert_eq!(
            fill(&row(&[bad; 5])),
            Repaired { color: row(&[0.0; 5]), valid: vec![false; 5] }
        );
    }

    #[test]
    fn one_bad_channel_makes_a_bad_pixel() {
        let mut image = Image::filled(3, 3, [1.0, -2.0, 3.0]).expect("a valid image");
        image.pixels_mut()[4] = NAN;
        assert_eq!(fill(&image).color.pixels(), [[1.0, -2.0, 3.0]; 9]);
    }

    #[test]
    fn negative_channels_stay_unless_the_luminance_is_negative() {
        let image = Image::new(3, 1, vec![[-1.0; 3], [-0.5, 2.0, 0.0], [3.0, -1.0, 0.0]]);
        let found = repair(&image.expect("a valid image"), 1.0, 256.0).color;
        assert_eq!(found.pixels(), [[0.0; 3], [-0.5, 2.0, 0.0], [3.0, 0.0, 0.0]]);
    }

    #[test]
    fn infinite_light_is_the_brightest_thing_around_and_the_other_channels_stay() {
        let inf = f32::INFINITY;
        for (around, expected) in [(0.5, 65504.0), (1e5, 1e5), (f32::MAX, 1e30)] {
            let mut image = Image::filled(6, 6, [around; 3]).expect("a valid image");
            let sun = [14, 15, 20, 21];
            for i in sun {
                image.pixels_mut()[i] = [inf, 30000.0, -8000.0];
            }
            let found = repair(&image, 1e-4, 256.0).color;
            assert_eq!(sun.map(|i| found.pixels()[i]), [[expected, 30000.0, -8000.0]; 4]);
        }
    }

    #[test]
    fn the_brightest_value_counts_up_to_two_pixels_away() {
        let inf = f32::INFINITY;
        for (place, expected) in [([0, 0], 7e4), ([2, 0], 7e4), ([4, 4], 7e4), ([5, 2], 65504.0)] {
            let mut image = Image::filled(7, 7, [1.0; 3]).expect("a valid image");
            for [x, y] in [[2, 1], [1, 2], [2, 2], [3, 2], [2, 3]] {
                image.pixels_mut()[y * 7 + x] = [inf; 3];
            }
            image.pixels_mut()[place[1] * 7 + place[0]] = [7e4; 3];
            let found = repair(&image, 1e-4, 256.0).color;
            assert_eq!(found.pixels()[2 * 7 + 2], [expected; 3], "{place:?}");
        }
    }

    #[test]
    fn up_to_three_infinite_pixels_together_are_fireflies_and_a_missing_one_in_a_sun_is_bright() {
        let inf = f32::INFINITY;
        let firefly = row(&[1.0, inf, inf, inf, 1.0, 1.0, inf]);
        assert_eq!(repair(&firefly, 1.0, 256.0).color, row(&[1.0; 7]));
        let mut sun = Image::filled(3, 3, [inf; 3]).expect("a valid image");
        sun.pixels_mut()[4] = NAN;
        assert_eq!(repair(&sun, 1.0, 256.0).color.pixels()[4], [65504.0; 3]);
        assert_eq!(repair(&row(&[f32::NEG_INFINITY, 2.0]), 1.0, 256.0).color, row(&[2.0; 2]));
    }

    #[test]
    fn an_outlier_is_darkened_to_256_times_its_brightest_neighbor_in_its_hue() {
        let mut image = Image::filled(5, 5, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[6] = [2.0; 3];
        image.pixels_mut()[12] = [1e30, 0.0, 0.0];
        let [r, g, b] = repair(&image, 1.0, 256.0).color.pixels()[12];
        assert!((f64::from(r) * 0.212_671 / 512.0 - 1.0).abs() < 1e-6 && g == 0.0 && b == 0.0);
        let others = |image: &Image| [image.pixels()[..12].to_vec(), image.pixels()[13..].to_vec()];
        assert_eq!(others(&repair(&image, 1.0, 256.0).color), others(&image));
    }

    #[test]
    fn what_is_bright_beside_bright_pixels_stays_and_so_does_what_is_only_256_times_gray() {
        let lamp = row(&[0.1, 1e4, 1e4, 0.1]);
        assert_eq!(repair(&lamp, 1.0, 256.0).color, lamp);
        let (below, above) = (row(&[0.0, 46.07, 0.0]), row(&[0.0, 46.09, 0.0]));
        assert_eq!(repair(&below, 1.0, 256.0).color, below);
        assert!((repair(&above, 1.0, 256.0).color.pixels()[1][0] - 46.08).abs() < 1e-5);
        assert_eq!(repair(&above, 0.5, 256.0).color, above);
    }

    #[test]
    fn data_that_is_no_light_is_only_filled() {
        let signed =
            Encoding { transfer_function: TransferFunction::Signed, ..Encoding::default() };
        let image = row(&[-1.0, f32::INFINITY, -0.5, 0.0, 1e4]);
        let found = repair_in(signed, &image, 1.0).color;
        assert_eq!(found, row(&[-1.0, -0.75, -0.5, 0.0, 1e4]));
        assert_eq!(repair_in(Encoding::default(), &image, 1.0), repair(&image, 1.0, 16.0));
    }
}
