//! The input scale that brings an image's average luminance to middle grey.

use super::input_process::sanitize_color;
use crate::image::Image;

/// The largest side of a bin, in pixels.
const BIN: usize = 16;
/// What the average luminance becomes: photography's middle grey.
const KEY: f64 = 0.18;
/// Bins at or below this luminance are black, and say nothing of the exposure.
const BLACK: f64 = 1e-8;
/// Brighter values count as this, so that sums of a bin and 65504 ÷ scale stay within f32.
const BRIGHTEST: f64 = 1e30;

/// `0.18 / 2^m`, where `m` is the mean of `log₂` of the luminance of all bins that are not
/// black; 1 if all are. Positive and finite for any image.
///
/// Each side is cut into the fewest bins of at most 16 pixels, as equal as they can be. A
/// bin's luminance is its pixels' mean, so that a few fireflies do not count as many dark
/// pixels do. After Intel Open Image Denoise's autoexposure, which follows Reinhard et al.,
/// "Photographic Tone Reproduction for Digital Images" (2002).
#[must_use]
pub fn autoexposure(color: &Image) -> f32 {
    let (width, height) = (color.width() as usize, color.height() as usize);
    let mut logs = Vec::new();
    for rows in bins(height) {
        for columns in bins(width) {
            let luminance = mean_luminance(color, rows.clone(), columns);
            if luminance > BLACK {
                logs.push(luminance.log2());
            }
        }
    }
    if logs.is_empty() {
        return 1.0;
    }
    (KEY / (logs.iter().sum::<f64>() / logs.len() as f64).exp2()) as f32
}

/// The pixels of each bin along a side.
fn bins(side: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let count = side.div_ceil(BIN);
    (0..count).map(move |i| i * side / count..(i + 1) * side / count)
}

fn mean_luminance(
    color: &Image,
    rows: std::ops::Range<usize>,
    columns: std::ops::Range<usize>,
) -> f64 {
    let count = (rows.len() * columns.len()) as f64;
    let mut sum = 0.0;
    for y in rows {
        for pixel in &color.row(y as u32)[columns.clone()] {
            let [r, g, b] = pixel.map(|value| sanitize_color(value).min(BRIGHTEST));
            sum += 0.212_671 * r + 0.715_160 * g + 0.072_169 * b;
        }
    }
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f32, expected: f32) {
        assert!((found / expected - 1.0).abs() < 1e-6, "found {found}, expected {expected}");
    }

    #[test]
    fn an_even_image_is_brought_to_middle_grey() {
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
        // 20 columns are two bins of 10: one of luminance 1, one of (9 · 0 + 160) / 10 = 16.
        let mut image = Image::filled(20, 1, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[10..].fill([0.0; 3]);
        image.pixels_mut()[15] = [160.0; 3];
        assert_near(autoexposure(&image), 0.18 / 4.0);
    }

    #[test]
    fn rows_are_binned_as_columns_are() {
        let mut image = Image::filled(1, 20, [1.0; 3]).expect("a valid image");
        image.pixels_mut()[10..].fill([16.0; 3]);
        assert_near(autoexposure(&image), 0.18 / 4.0);
    }

    #[test]
    fn black_bins_and_broken_values_do_not_count() {
        let mut image = Image::filled(40, 1, [2.0; 3]).expect("a valid image");
        image.pixels_mut()[..13].fill([1e-9; 3]);
        image.pixels_mut()[13..26].fill([f32::NAN, f32::INFINITY, -5.0]);
        assert_near(autoexposure(&image), 0.09);
        // Of the last bin's 14 pixels, half are now broken.
        image.pixels_mut()[26..33].fill([f32::NAN, f32::INFINITY, -5.0]);
        assert_near(autoexposure(&image), 0.18);
        assert_eq!(autoexposure(&Image::filled(5, 5, [0.0; 3]).expect("a valid image")), 1.0);
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
