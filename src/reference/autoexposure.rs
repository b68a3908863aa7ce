//! The input scale that brings an image's average luminance to middle gray.

use super::repair::{GREY, MOST, OUTLIER, is_finite, luminance};
use crate::image::Image;

/// Longest side of a bin in pixels.
const BIN: usize = 16;
/// A bin this many times darker than the brightest is black and tells nothing about the exposure.
const RANGE: f64 = (1_u64 << 33) as f64;
/// Darker bins are black: many GPUs flush smaller values to 0.
const DARKEST: f64 = f32::MIN_POSITIVE as f64;

/// `0.18 / 2^m`, where `m` is the mean of `log₂` of the luminance over all lit bins; 1 if none is
/// lit. Positive and finite for any image.
///
/// Each side is divided into the fewest bins of at most 16 pixels, as equal as possible. A bin's
/// luminance is the mean over its finite pixels, with negative values counting as 0 and the
/// brightest pixel as at most 16 times the second brightest. A bin is lit if it exceeds the
/// smallest normal 32-bit float and is at most 2³³ times darker than the brightest bin. A bin with
/// a single lit pixel and no other light may be black apart from a firefly; such bins count only if
/// the image has no other light.
///
/// After the autoexposure of Intel Open Image Denoise, which follows Reinhard et al., "Photographic
/// Tone Reproduction for Digital Images" (2002). That one neither limits the brightest pixel nor
/// treats single pixels specially, and takes bins of at most 1e-8 for black.
#[must_use]
pub fn autoexposure(color: &Image) -> f32 {
    let (width, height) = (color.width() as usize, color.height() as usize);
    let places =
        bins(height).flat_map(|rows| bins(width).map(move |columns| (rows.clone(), columns)));
    let all: Vec<Bin> = places.map(|(rows, columns)| bin(color, rows, columns)).collect();
    let any = all.iter().any(|bin| bin.mean >= DARKEST && !bin.lone);
    let means: Vec<f64> = all.iter().filter(|bin| bin.lone != any).map(|bin| bin.mean).collect();
    let brightest = means.iter().copied().fold(0.0, f64::max);
    let lit = means.into_iter().filter(|&mean| mean >= DARKEST && mean > brightest / RANGE);
    let logs: Vec<f64> = lit.map(f64::log2).collect();
    if logs.is_empty() {
        return 1.0;
    }
    (GREY / (logs.iter().sum::<f64>() / logs.len() as f64).exp2()) as f32
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
        lights[0] = lights[0].min(OUTLIER * lights[1]);
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
        let mut image = Image::filled(40, 1, [2.0; 3]).expect("a valid image");
        image.pixels_mut()[..13].fill([1e-10; 3]);
        image.pixels_mut()[13..26].fill([1.0, f32::INFINITY, 1.0]);
        assert_near(autoexposure(&image), 0.09);
        // Of the last bin's 14 pixels, half are now bad, and the others make the mean.
        image.pixels_mut()[26..33].fill([f32::NAN, 1.0, 1.0]);
        assert_near(autoexposure(&image), 0.09);
        // Negative values count as 0.
        image.pixels_mut()[26..33].fill([-5.0; 3]);
        assert_near(autoexposure(&image), 0.18);
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
            // The mean of the logarithms of 1, 0.5, 2 and 3e-9.
            assert_near(autoexposure(&image) * exposure, 0.18 / 3e-9_f32.powf(0.25));
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
