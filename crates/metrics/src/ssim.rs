//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From
//! Error Visibility to Structural Similarity" (2004), computed as scikit-image does with
//! `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1`.

use super::{Pixel, mean};
use std::ops::Range;

/// Standard deviation of the Gaussian window, in pixels.
const SIGMA: f64 = 1.5;
/// Radius of the window: 3.5 standard deviations, rounded.
const RADIUS: usize = 5;
/// Keeps the quotients finite where both images are black or constant, for values in `[0, 1]`.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean over the channels and over the pixels around which the whole window fits.
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
    let (mean_x, mean_r) = (blurred(x, width), blurred(r, width));
    let (square_x, square_r) = (blurred(&product(x, x), width), blurred(&product(r, r), width));
    let cross = blurred(&product(x, r), width);
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
    if side > 2 * RADIUS { RADIUS..side - RADIUS } else { 0..side }
}

/// The plane's Gaussian mean around each pixel: first along the rows, then along the columns.
fn blurred(plane: &[f64], width: usize) -> Vec<f64> {
    let (columns, rows) = (windows(width), windows(plane.len() / width));
    let mut across = Vec::with_capacity(plane.len());
    for row in plane.chunks_exact(width) {
        let seen = |window: &Window| {
            let pairs = row[window.start..].iter().zip(&window.weights);
            pairs.map(|(v, weight)| v * weight).sum::<f64>()
        };
        across.extend(columns.iter().map(seen));
    }
    let mut both = vec![0.0; plane.len()];
    for (sums, window) in both.chunks_exact_mut(width).zip(&rows) {
        let seen = across[window.start * width..].chunks_exact(width).zip(&window.weights);
        for (row, weight) in seen {
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * weight);
        }
    }
    both
}

/// The Gaussian window around one position along a side.
struct Window {
    start: usize,
    /// Weights starting at `start`. They sum to 1 even where the border clips the window.
    weights: Vec<f64>,
}

/// The window around each position along a side.
fn windows(side: usize) -> Vec<Window> {
    let window = |center: usize| {
        let start = center.saturating_sub(RADIUS);
        let end = side.min(center + RADIUS + 1);
        let gaussian = |i: usize| (-0.5 * (i.abs_diff(center) as f64 / SIGMA).powi(2)).exp();
        let sum: f64 = (start..end).map(gaussian).sum();
        Window { start, weights: (start..end).map(|i| gaussian(i) / sum).collect() }
    };
    (0..side).map(window).collect()
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
    fn an_impulse_blurs_to_the_gaussian_along_its_own_axes() {
        let mut plane = vec![0.0; 17 * 16];
        plane[7 * 17 + 8] = 1.0;
        let found = blurred(&plane, 17);
        let sum: f64 = (-5..=5).map(|i| (-f64::from(i * i) / 4.5).exp()).sum();
        for (x, y, distance_squared) in [(8, 7, 0.0), (10, 7, 4.0), (8, 10, 9.0), (11, 5, 13.0)] {
            assert_near(found[y * 17 + x], (-distance_squared / 4.5_f64).exp() / (sum * sum));
        }
        assert_near(found[7 * 17 + 14], 0.0);
    }

    #[test]
    fn only_places_that_see_the_whole_window_count() {
        assert_eq!((interior(11), interior(30), interior(10)), (5..6, 5..25, 0..10));
    }
}
