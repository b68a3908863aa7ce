//! The input scale that brings an image's average luminance to middle gray.

use super::repair::{GREY, MOST, is_finite, luminance};
use crate::image::Image;

/// Longest side of a bin in pixels.
const BIN: usize = 16;
/// The brightest pixel of a bin counts as at most this many times the second brightest.
const SPIKE: f64 = 16.0;
/// Darker bins are black: many GPUs flush smaller values to 0.
const DARKEST: f64 = f32::MIN_POSITIVE as f64;

/// `0.18 / 2^m`, where `m` is the weighted mean of `log₂` of the luminance over all lit bins; 1 if
/// none is lit. Positive and finite for any image.
///
/// Each side is divided into the fewest bins of at most 16 pixels, as equal as possible. A bin's
/// luminance is the mean over its finite pixels, with negative values counting as 0 and the
/// brightest pixel as at most 16 times the second brightest. A bin is lit if it exceeds the
/// smallest normal 32-bit float. A bin with a single lit pixel and no other light may be black
/// apart from a firefly; such bins count only if the image has no other light.
///
/// The bright bins decide which others say something about the exposure. `q` is the bin that is
/// brighter than 95 % of the lit ones, which neither a few lamps nor a dark background of up to
/// four fifths can move out of the scene. Bins 2¹¹ times darker than `q` have no weight, those up
/// to 2⁹ times darker have full weight, with a linear transition in `log₂`.
///
/// After the autoexposure of Intel Open Image Denoise, which follows Reinhard et al., "Photographic
/// Tone Reproduction for Digital Images" (2002). The original neither limits the brightest pixel
/// nor treats single pixels specially, and gives all bins above 1e-8 the same weight.
#[must_use]
pub fn autoexposure(color: &Image) -> f32 {
    let (width, height) = (color.width() as usize, color.height() as usize);
    let places =
        bins(height).flat_map(|rows| bins(width).map(move |columns| (rows.clone(), columns)));
    let all: Vec<Bin> = places.map(|(rows, columns)| bin(color, rows, columns)).collect();
    let lit: Vec<&Bin> = all.iter().filter(|bin| bin.mean >= DARKEST).collect();
    let any = lit.iter().any(|bin| !bin.lone);
    let counted = lit.into_iter().filter(|bin| bin.lone != any);
    let logs: Vec<f64> = counted.map(|bin| bin.mean.log2()).collect();
    if logs.is_empty() {
        return 1.0;
    }
    (GREY / mean_of_bright(logs).exp2()) as f32
}

/// The mean of the logarithms that are not too far below the bright ones.
fn mean_of_bright(mut logs: Vec<f64>) -> f64 {
    logs.sort_by(f64::total_cmp);
    let q = logs[(logs.len() - 1) * 19 / 20];
    let weight = |log: f64| ((log - (q - 11.0)) / 2.0).clamp(0.0, 1.0);
    let sum: f64 = logs.iter().map(|&log| weight(log) * log).sum();
    sum / logs.iter().map(|&log| weight(log)).sum::<f64>()
}

struct Bin {
    mean: f64,
    /// Whether exactly one of several pixels is lit.
    lone: bool,
}

/// The pixels of each bin along a side.
fn bins(side: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let count = side.div_ceil(BIN);
    (0..count).map(move |i| i * side / count..(i + 1) * side / count)
}

fn bin(color: &Image, rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> Bin {
    let pixels = rows.flat_map(|y| color.row(y as u32)[columns.clone()].to_vec());
    let finite = pixels.filter(|pixel| is_finite(*pixel));
    let mut lights: Vec<f64> =
        finite.map(|pixel| luminance(pixel.map(|v| v.clamp(0.0, MOST)))).collect();
    lights.sort_by(|a, b| b.total_cmp(a));
    let lone = lights.len() > 1 && lights[0] > 0.0 && lights[1] == 0.0;
    if lights.len() > 1 && !lone {
        lights[0] = lights[0].min(SPIKE * lights[1]);
    }
    // A bin without a finite pixel is black.
    Bin { mean: lights.iter().sum::<f64>() / lights.len().max(1) as f64, lone }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f32, expected: f32) {
        assert!((found / expected - 1.0).abs() < 1e-6, "found {found}, expected {expected}");
    }

    #[test]
    fn an_even_image_is_brought_to_middle_gray() {
        let image = Image::filled(33, 17, [4.0; 3]).expect("a valid image");
        assert_near(autoexposure(&image), 0.045);
    }

    #[test]
    fn channels_count_by_their_luminance() {
        for (channel, weight) in [0.212_671, 0.715_160, 0.072_169].into_iter().enumerate() {
            let mut pixel = [0.0; 3];
            pixel[channel] = 1.0;
            let image = Image::filled(1, 1, pixel).expect("a valid image");
            assert_near(autoexposure(&image), 0.18 / weight);
        }
    }

    #[test]
    fn bins_are_averaged_before_and_after_the_logarithm_as_defined() {
        // 20 columns are two bins of 10: one of luminance 1, one of (8 · 0 + 2 · 80) / 10 = 16.
        let mut image = Image::filled(20, 1, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[10..].fill([0.0; 3]);
        image.pixels_mut()[15..17].fill([80.0; 3]);
        assert_near(autoexposure(&image), 0.18 / 4.0);
    }

    #[test]
    fn rows_are_binned_as_columns_are() {
        let mut image = Image::filled(1, 20, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[10..].fill([16.0; 3]);
        assert_near(autoexposure(&image), 0.18 / 4.0);
    }

    #[test]
    fn black_bins_and_bad_pixels_do_not_count() {
        let mut image = Image::filled(56, 1, [2.0; 3]).expect("a valid image");
        image.pixels_mut()[..14].fill([1e-10; 3]);
        image.pixels_mut()[14..28].fill([1.0, f32::INFINITY, 1.0]);
        assert_near(autoexposure(&image), 0.09);
        // Of the third bin's 14 pixels, half are now bad, and the others make the mean.
        image.pixels_mut()[28..35].fill([f32::NAN, 1.0, 1.0]);
        assert_near(autoexposure(&image), 0.09);
        // Negative values count as 0: the bins have 1 and 2.
        image.pixels_mut()[28..35].fill([-5.0; 3]);
        assert_near(autoexposure(&image), 0.18 / 2_f32.sqrt());
        for black in [0.0, -1.0, f32::NAN, 1e-42] {
            let image = Image::filled(5, 5, [black; 3]).expect("a valid image");
            assert_eq!(autoexposure(&image), 1.0);
        }
    }

    #[test]
    fn the_scale_follows_the_exposure_over_the_whole_range() {
        let values = [1.0, 0.5, 3e-9, 0.0, 2.0].map(|v| [v; 3]);
        for exposure in [1e-25, 1e-12, 1.0, 1e12, 1e25] {
            let pixels = values.iter().flat_map(|p| vec![p.map(|v| v * exposure); 16]).collect();
            let image = Image::new(80, 1, pixels).expect("a valid image");
            // The mean of the logarithms of 1, 0.5 and 2. That of 3e-9 is too far below.
            assert_near(autoexposure(&image) * exposure, 0.18);
        }
    }

    #[test]
    fn one_pixel_cannot_move_a_bin_by_more_than_the_second_brightest_allows() {
        let mut image = Image::filled(16, 16, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[99] = [f32::MAX; 3];
        assert_near(autoexposure(&image), 0.18 / ((255.0 + 16.0) / 256.0));
    }

    #[test]
    fn a_lone_pixel_on_black_counts_only_where_nothing_else_is_lit() {
        let mut image = Image::filled(48, 16, [0.0; 3]).expect("a valid image");
        image.pixels_mut()[7] = [256.0; 3];
        image.pixels_mut()[20] = [4.0 * 256.0; 3];
        assert_near(autoexposure(&image), 0.18 / 2.0);
        for x in 32..48 {
            image.pixels_mut()[48 * 9 + x] = [16.0; 3];
        }
        assert_near(autoexposure(&image), 0.18);
    }

    #[test]
    fn the_weight_of_a_bin_fades_between_512_and_2048_times_darker_than_the_bright_ones() {
        let dark = [(9.0, 1.0), (9.5, 0.75), (10.0, 0.5), (11.0, 0.0), (20.0, 0.0)];
        for (steps, weight) in dark {
            let mut image = Image::filled(48, 1, [1.0; 3]).expect("a valid image");
            image.pixels_mut()[16..32].fill([(-steps as f32).exp2(); 3]);
            let mean: f64 = -weight * steps / (2.0 + weight);
            assert_near(autoexposure(&image), 0.18 / mean.exp2() as f32);
        }
    }

    #[test]
    fn nineteen_in_twenty_lit_bins_are_darker_than_the_bright_one() {
        // Of 21 bins, the 20th by brightness decides: with one lamp, that is the scene.
        for (lamps, counted) in [(1, 21.0), (2, 2.0)] {
            let mut image = Image::filled(21 * 16, 1, [1.0; 3]).expect("a valid image");
            image.pixels_mut()[..16 * lamps].fill([65536.0; 3]);
            let mean = 16.0 * lamps as f32 / counted;
            assert_near(autoexposure(&image), 0.18 / mean.exp2());
        }
    }

    #[test]
    fn bins_cover_a_side_once_and_none_is_larger_than_allowed() {
        for side in 1..200 {
            let bins: Vec<_> = bins(side).collect();
            assert_eq!(
                bins.iter().cloned().flatten().collect::<Vec<_>>(),
                (0..side).collect::<Vec<_>>()
            );
            assert!(bins.iter().all(|bin| (1..=BIN).contains(&bin.len())), "{side}: {bins:?}");
        }
    }
}
