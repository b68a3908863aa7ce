//! Replaces pixels that no network should see: see [`fill`] and [`repair`].

use crate::image::Image;

/// The luminance of middle gray: the image's average, times the input scale.
pub const GREY: f64 = 0.18;
/// How many times brighter than its surroundings a pixel may be.
pub const OUTLIER: f64 = 16.0;
/// Values are clamped to ± this, so that no sum or quotient exceeds 32 bits.
pub const MOST: f32 = 1e30;

/// The image without bad pixels. A pixel that is not finite in all channels becomes the mean of the
/// finite ones among the eight around it, or else among the 24 around it, or else black. For the
/// mean, values are clamped to ±1e30.
#[must_use]
pub fn fill(image: &Image) -> Image {
    let filled = |pixel, [x, y]: [i64; 2]| {
        if is_finite(pixel) {
            return pixel;
        }
        let rings = [1, 2].map(|distance| around(image, [x, y], distance));
        let finite = rings.into_iter().find(|ring| !ring.is_empty()).unwrap_or_default();
        let count = finite.len().max(1) as f64;
        let sum = |c: usize| finite.iter().map(|p| f64::from(p[c].clamp(-MOST, MOST))).sum::<f64>();
        [0, 1, 2].map(|c| (sum(c) / count) as f32)
    };
    map(image, filled)
}

/// Noisy color as the network sees it: [filled](fill), clamped to `[0, 1e30]`, and without
/// outliers. No pixel is brighter than 16 times the brightest finite one of the eight around it or
/// 16 times middle gray, `0.18 / input_scale`, whichever is more; brighter pixels are darkened to
/// that limit, keeping their hue.
#[must_use]
pub fn repair(color: &Image, input_scale: f32) -> Image {
    let lit = map(&fill(color), |pixel, _| pixel.map(|v| v.clamp(0.0, MOST)));
    map(&lit, |pixel, place| {
        let neighbors = around(color, place, 1);
        let lights = neighbors.iter().map(|p| luminance(p.map(|v| v.clamp(0.0, MOST))));
        let most = OUTLIER * lights.fold(GREY / f64::from(input_scale), f64::max);
        let share = (most / luminance(pixel)).min(1.0);
        if luminance(pixel) > most { pixel.map(|v| (f64::from(v) * share) as f32) } else { pixel }
    })
}

/// Luminance of linear color with Rec. 709 primaries.
pub(super) fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.212_671 * f64::from(r) + 0.715_160 * f64::from(g) + 0.072_169 * f64::from(b)
}

pub(super) fn is_finite(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|v| v.is_finite())
}

fn map(image: &Image, pixel: impl Fn([f32; 3], [i64; 2]) -> [f32; 3]) -> Image {
    let mut result = image.clone();
    let width = i64::from(image.width());
    for (i, value) in (0..).zip(result.pixels_mut()) {
        *value = pixel(*value, [i % width, i / width]);
    }
    result
}

/// The finite pixels up to `distance` away, counting diagonal steps, except the center.
fn around(image: &Image, [x, y]: [i64; 2], distance: i64) -> Vec<[f32; 3]> {
    let (width, height) = (i64::from(image.width()), i64::from(image.height()));
    let steps = || -distance..=distance;
    let places = steps().flat_map(|dy| steps().map(move |dx| [dx, dy]));
    let others = places.filter(|step| *step != [0, 0]).map(|[dx, dy]| [x + dx, y + dy]);
    let inside = others.filter(|[x, y]| (0..width).contains(x) && (0..height).contains(y));
    inside.map(|[x, y]| image.row(y as u32)[x as usize]).filter(|p| is_finite(*p)).collect()
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
            assert_eq!(fill(&row(&[9.0, 1.0, bad, 4.0, 9.0])), row(&[9.0, 1.0, 2.5, 4.0, 9.0]));
            assert_eq!(fill(&row(&[bad, 3.0])), row(&[3.0, 3.0]));
        }
    }

    #[test]
    fn a_pixel_among_bad_ones_looks_two_pixels_far_and_then_is_black() {
        let (bad, filled) = (f32::NAN, 6.0);
        assert_eq!(fill(&row(&[6.0, bad, bad, bad])), row(&[6.0, filled, filled, 0.0]));
        assert_eq!(fill(&row(&[bad; 5])), row(&[0.0; 5]));
    }

    #[test]
    fn one_bad_channel_makes_a_bad_pixel() {
        let mut image = Image::filled(3, 3, [1.0, -2.0, 3.0]).expect("a valid image");
        image.pixels_mut()[4] = NAN;
        assert_eq!(fill(&image).pixels(), [[1.0, -2.0, 3.0]; 9]);
    }

    #[test]
    fn negative_light_is_none() {
        assert_eq!(repair(&row(&[-1.0, -0.5, 2.0]), 1.0), row(&[0.0, 0.0, 2.0]));
    }

    #[test]
    fn an_outlier_is_darkened_to_sixteen_times_its_brightest_neighbor_in_its_hue() {
        let mut image = Image::filled(5, 5, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[6] = [2.0; 3];
        image.pixels_mut()[12] = [1e30, 0.0, 0.0];
        let [r, g, b] = repair(&image, 1.0).pixels()[12];
        assert!((f64::from(r) * 0.212_671 / 32.0 - 1.0).abs() < 1e-6 && g == 0.0 && b == 0.0);
        let others = |image: &Image| [image.pixels()[..12].to_vec(), image.pixels()[13..].to_vec()];
        assert_eq!(others(&repair(&image, 1.0)), others(&image));
    }

    #[test]
    fn what_is_bright_beside_bright_pixels_stays_and_so_does_what_is_only_sixteen_times_gray() {
        let lamp = row(&[0.1, 1e4, 1e4, 0.1]);
        assert_eq!(repair(&lamp, 1.0), lamp);
        let (below, above) = (row(&[0.0, 2.87, 0.0]), row(&[0.0, 2.89, 0.0]));
        assert_eq!(repair(&below, 1.0), below);
        assert!((repair(&above, 1.0).pixels()[1][0] - 2.88).abs() < 1e-5);
        assert_eq!(repair(&above, 0.5), above);
    }
}
