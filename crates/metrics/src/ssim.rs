//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From
//! Error Visibility to Structural Similarity" (2004), computed as scikit-image does with
//! `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1`.

use super::window::Gaussian;
use super::{Pixel, mean};
use std::ops::Range;

/// Its radius is 3.5 standard deviations, rounded.
const WINDOW: Gaussian = Gaussian { radius: 5, sigma: 1.5 };
/// Keeps the quotients finite where both images are black or constant, for values in `[0, 1]`.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean SSIM over the channels and over the pixels around which the whole window fits.
///
/// If the window is larger than a side, all pixels along that side count, with the window clipped
/// at the border.
pub(super) fn ssim(x: &[Pixel], r: &[Pixel], width: usize) -> f64 {
    let channel =
        |pixels: &[Pixel], c: usize| -> Vec<f64> { pixels.iter().map(|pixel| pixel[c]).collect() };
    let of_channel = |c| channel_ssim(&channel(x, c), &channel(r, c), width);
    mean([0, 1, 2].into_iter().map(of_channel))
}

fn channel_ssim(x: &[f64], r: &[f64], width: usize) -> f64 {
    let product =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let blurred = |plane: &[f64]| WINDOW.blurred(plane, width);
    let (mean_x, mean_r) = (blurred(x), blurred(r));
    let (square_x, square_r) = (blurred(&product(x, x)), blurred(&product(r, r)));
    let cross = blurred(&product(x, r));
    let similarity = |i: usize| {
        let (x, r) = (mean_x[i], mean_r[i]);
        let variances = square_x[i] - x * x + square_r[i] - r * r;
        let covariance = cross[i] - x * r;
        (2.0 * x * r + C1) / (x * x + r * r + C1) * (2.0 * covariance + C2) / (variances + C2)
    };
    let row = |y: usize| mean(interior(width).map(|column| similarity(y * width + column)));
    mean(interior(x.len() / width).map(row))
}

/// The positions along a side around which the whole window fits, or all if there are none.
fn interior(side: usize) -> Range<usize> {
    let radius = WINDOW.radius;
    if side > 2 * radius { radius..side - radius } else { 0..side }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn even_planes_differ_by_their_luminance_alone() {
        let (x, r) = (0.25, 0.75);
        let expected = (2.0 * x * r + C1) / (x * x + r * r + C1);
        for (width, height) in [(1, 1), (3, 20), (20, 3), (11, 12)] {
            let size = width * height;
            assert_near(channel_ssim(&vec![x; size], &vec![r; size], width), expected);
        }
    }

    #[test]
    fn opposite_planes_are_dissimilar() {
        let x: Vec<f64> = (0..400).map(|i| f64::from((i / 20 + i % 20) % 2)).collect();
        let inverse: Vec<f64> = x.iter().map(|v| 1.0 - v).collect();
        assert_near(channel_ssim(&x, &x, 20), 1.0);
        assert!(channel_ssim(&x, &inverse, 20) < -0.98);
    }

    #[test]
    fn only_places_that_see_the_whole_window_count() {
        assert_eq!((interior(11), interior(30), interior(10)), (5..6, 5..25, 0..10));
    }
}
