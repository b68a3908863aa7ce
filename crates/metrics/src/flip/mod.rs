//! FLIP: how different two pictures look when alternated in the same place.
//!
//! LDR-FLIP of Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images" (2020). Colors are blurred as much as the eye blurs
//! them at the viewing distance, then compared; differences of edges and points, which draw the
//! eye, raise the error.

mod color;
mod filter;

use std::f64::consts::PI;
use std::ops::Range;
use std::panic::resume_unwind;
use std::thread;

use color::{hunt_lab, hyab, linear, of_opponents, opponents};
use filter::{Row, across, down};

use super::{Pixel, mean};
use wgdenoise::{Error, Image, Result};

/// Pixels per degree of the visual field: a 4K monitor, 0.7 m wide, from 0.7 m away.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// The exponents of color and feature differences.
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// Color differences up to this fraction of the largest one fill most of the error's range.
const KNEE: f64 = 0.4;
const KNEE_ERROR: f64 = 0.95;
/// The width of the edges and points that the eye detects, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// The FLIP errors of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Row by row, from 0 for no visible difference to 1.
    pub errors: Vec<f32>,
    /// The mean of all pixels.
    pub mean: f64,
}

/// Compares display-referred pictures: sRGB-encoded values, clipped to [0, 1]; NaN counts as 0.
/// `pixels_per_degree` is usually [`PIXELS_PER_DEGREE`]. The order of the pictures does not matter.
///
/// # Errors
/// If the two differ in size.
pub fn flip(image: &Image, reference: &Image, pixels_per_degree: f64) -> Result<Flip> {
    if image.size() != reference.size() {
        let ((w, h), (rw, rh)) = (image.size(), reference.size());
        return Err(Error::Image(format!(
            "an image of {w}×{h} cannot be compared with a reference of {rw}×{rh}; give two images \
             of the same size"
        )));
    }
    let height = image.height() as usize;
    let rows = height.div_ceil(thread::available_parallelism().map_or(1, usize::from));
    let band = |top| band([image, reference], top..(top + rows).min(height), pixels_per_degree);
    let errors: Vec<f64> = thread::scope(|scope| {
        let tops = (0..height).step_by(rows);
        let bands: Vec<_> = tops.map(|top| scope.spawn(move || band(top))).collect();
        let joined = bands.into_iter().map(|band| band.join().unwrap_or_else(|e| resume_unwind(e)));
        joined.flatten().collect()
    });
    let mean = mean(errors.iter().copied());
    Ok(Flip { errors: errors.into_iter().map(|error| error as f32).collect(), mean })
}

/// The errors of a band of rows; the filters also read the rows around it.
fn band(images: [&Image; 2], rows: Range<usize>, pixels_per_degree: f64) -> Vec<f64> {
    let (width, height) = (images[0].width() as usize, images[0].height() as usize);
    let reach = contrast_radius(pixels_per_degree).max(feature_radius(pixels_per_degree));
    let around = rows.start.saturating_sub(reach)..(rows.end + reach).min(height);
    let seen = |image: &Image| {
        let pixels = &image.pixels()[around.start * width..around.end * width];
        Seen::of(pixels, width, pixels_per_degree)
    };
    let ([image, reference], most) = (images.map(seen), most());
    let first = (rows.start - around.start) * width;
    (first..).take(rows.len() * width).map(|i| image.error(&reference, i, most)).collect()
}

/// A picture as the eye sees it.
struct Seen {
    /// Luminance and opponent channels, blurred.
    colors: [Vec<f32>; 3],
    /// The strength of edges and of points.
    features: [Vec<f32>; 2],
}

impl Seen {
    fn of(pixels: &[[f32; 3]], width: usize, pixels_per_degree: f64) -> Self {
        let clipped = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        let mut planes = [0, 1, 2].map(|_| Vec::with_capacity(pixels.len()));
        for pixel in pixels {
            let channels = opponents(linear(pixel.map(clipped)));
            planes.iter_mut().zip(channels).for_each(|(plane, v)| plane.push(v as f32));
        }
        let luminance: Vec<f32> = planes[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        let blur = |i: usize| blurred(&planes[i], width, CONTRAST[i], pixels_per_degree);
        let features = features(&luminance, width, pixels_per_degree);
        Self { colors: [0, 1, 2].map(blur), features }
    }

    /// The color of a pixel in Hunt-adjusted CIELAB.
    fn lab(&self, i: usize) -> Pixel {
        let color = of_opponents([0, 1, 2].map(|channel| f64::from(self.colors[channel][i])));
        hunt_lab(color.map(|v| v.clamp(0.0, 1.0)))
    }

    /// The error of a pixel, from 0 to 1; `most` is the largest color difference.
    fn error(&self, reference: &Self, i: usize, most: f64) -> f64 {
        let difference = hyab(self.lab(i), reference.lab(i)).powf(COLOR_EXPONENT);
        let apart = |f: usize| (self.features[f][i] - reference.features[f][i]).abs();
        let feature = f64::from(apart(0).max(apart(1))) / 2.0_f64.sqrt();
        let feature = feature.powf(FEATURE_EXPONENT).min(1.0);
        redistributed(difference, most).powf(1.0 - feature).clamp(0.0, 1.0)
    }
}

/// Contrast sensitivity to luminance, red–green and blue–yellow: sums of Gaussians, each with a
/// weight and a squared width in degrees.
const CONTRAST: [[(f64, f64); 2]; 3] = [
    [(1.0, 0.0047), (0.0, 0.00001)],
    [(1.0, 0.0053), (0.0, 0.00001)],
    [(34.1, WIDEST), (13.5, 0.025)],
];
const WIDEST: f64 = 0.04;

/// The standard deviation in pixels of a Gaussian of [`CONTRAST`].
fn sigma(width: f64, pixels_per_degree: f64) -> f64 {
    (width / (2.0 * PI * PI)).sqrt() * pixels_per_degree
}

/// The filter radius for all channels: that of the widest Gaussian.
fn contrast_radius(pixels_per_degree: f64) -> usize {
    (3.0 * sigma(WIDEST, pixels_per_degree)).ceil() as usize
}

/// Filters a channel by its contrast sensitivity.
fn blurred(
    plane: &[f32],
    width: usize,
    contrast: [(f64, f64); 2],
    pixels_per_degree: f64,
) -> Vec<f32> {
    let radius = contrast_radius(pixels_per_degree);
    let sigma = |b: f64| sigma(b, pixels_per_degree);
    let weight = |(a, b): (f64, f64)| a * (PI / b).sqrt() * square(radius, sigma(b));
    let sum: f64 = contrast.into_iter().map(weight).sum();
    let mut blurred = vec![0.0; plane.len()];
    for (a, b) in contrast.into_iter().filter(|(a, _)| *a > 0.0) {
        let (row, part) = (Row::gaussian(radius, sigma(b)), (weight((a, b)) / sum) as f32);
        let through = down(&across(plane, width, &row), width, &row);
        blurred.iter_mut().zip(through).for_each(|(sum, v)| *sum += part * v);
    }
    blurred
}

/// Sums a Gaussian of height 1 over a square of pixels.
fn square(radius: usize, sigma: f64) -> f64 {
    let radius = radius as i32;
    let line = (-radius..=radius).map(|x| (-0.5 * (f64::from(x) / sigma).powi(2)).exp());
    line.sum::<f64>().powi(2)
}

fn feature_sigma(pixels_per_degree: f64) -> f64 {
    0.5 * FEATURE_WIDTH * pixels_per_degree
}

fn feature_radius(pixels_per_degree: f64) -> usize {
    (3.0 * feature_sigma(pixels_per_degree)).ceil() as usize
}

/// The strength of edges and of points at each pixel of a luminance plane.
fn features(luminance: &[f32], width: usize, pixels_per_degree: f64) -> [Vec<f32>; 2] {
    let (sigma, radius) = (feature_sigma(pixels_per_degree), feature_radius(pixels_per_degree));
    let gaussian = Row::gaussian(radius, sigma);
    let smooth = across(luminance, width, &gaussian);
    [Row::edge(radius, sigma), Row::point(radius, sigma)].map(|row| {
        let along_rows = down(&across(luminance, width, &row), width, &gaussian);
        let along_columns = down(&smooth, width, &row);
        along_rows.iter().zip(&along_columns).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    })
}

/// The largest color difference: between green and blue.
fn most() -> f64 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
    hyab(green, blue).powf(COLOR_EXPONENT)
}

/// Maps a color difference to an error from 0 to 1; small differences get most of the range.
fn redistributed(difference: f64, most: f64) -> f64 {
    let knee = KNEE * most;
    if difference < knee {
        return KNEE_ERROR / knee * difference;
    }
    KNEE_ERROR + (difference - knee) / (most - knee) * (1.0 - KNEE_ERROR)
}

#[cfg(test)]
mod tests;
