//! FLIP: how different two pictures look when they are shown in turn in the same place.
//!
//! LDR-FLIP of Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images" (2020). Colors are first blurred as much as the eye blurs them at
//! the viewing distance, then compared; differences of edges and points, which draw the eye, raise the
//! error.

mod color;
mod filter;

use std::f64::consts::PI;

use color::{hunt_lab, hyab, linear, of_opponents, opponents};
use filter::{Row, filtered};

use super::{Pixel, mean};
use wgdenoise::{Error, Image, Result};

/// Pixels per degree of the visual field: a 4K monitor, 0.7 m wide, from 0.7 m away.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// The exponents of color and feature differences.
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// Color differences up to this part of the largest one share most of the range of the error.
const KNEE: f64 = 0.4;
const KNEE_ERROR: f64 = 0.95;
/// The width of the edges and points that the eye finds, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// The error of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Row by row, from 0 for no visible difference to 1.
    pub errors: Vec<f32>,
    /// The mean of all pixels.
    pub mean: f64,
}

/// Compares display-referred pictures: sRGB-encoded values from 0 to 1, which are clipped to that; NaN
/// counts as 0. `pixels_per_degree` is usually [`PIXELS_PER_DEGREE`]. The order does not matter.
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
    let [seen, expected] = [image, reference].map(|image| Seen::of(image, pixels_per_degree));
    let most = most();
    let error = |i: usize| {
        let color = redistributed(hyab(seen.lab[i], expected.lab[i]).powf(COLOR_EXPONENT), most);
        let [edge, point] = [0, 1].map(|f| (seen.features[f][i] - expected.features[f][i]).abs());
        let feature = (edge.max(point) / 2.0_f64.sqrt()).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature.min(1.0)).clamp(0.0, 1.0)
    };
    let errors: Vec<f64> = (0..seen.lab.len()).map(error).collect();
    let mean = mean(errors.iter().copied());
    Ok(Flip { errors: errors.into_iter().map(|error| error as f32).collect(), mean })
}

/// What the eye has of a picture.
struct Seen {
    /// Blurred colors in Hunt-adjusted CIELAB.
    lab: Vec<Pixel>,
    /// How strong edges and points are.
    features: [Vec<f64>; 2],
}

impl Seen {
    fn of(image: &Image, pixels_per_degree: f64) -> Self {
        let clipped = |v: f32| if v.is_nan() { 0.0 } else { f64::from(v).clamp(0.0, 1.0) };
        let width = image.width() as usize;
        let light = image.pixels().iter().map(|pixel| linear(pixel.map(clipped)));
        let pixels: Vec<Pixel> = light.map(opponents).collect();
        let plane = |i: usize| -> Vec<f64> { pixels.iter().map(|pixel| pixel[i]).collect() };
        let luminance: Vec<f64> = pixels.iter().map(|[y, ..]| (y + 16.0) / 116.0).collect();
        let blurred = [0, 1, 2].map(|i| blurred(&plane(i), width, CONTRAST[i], pixels_per_degree));
        let color = |i: usize| of_opponents([0, 1, 2].map(|channel| blurred[channel][i]));
        let lab = |i: usize| hunt_lab(color(i).map(|v| v.clamp(0.0, 1.0)));
        let features = features(&luminance, width, pixels_per_degree);
        Self { lab: (0..pixels.len()).map(lab).collect(), features }
    }
}

/// The contrast sensitivity of luminance, red–green and blue–yellow: sums of Gaussians, of which each
/// has a weight and a squared width in degrees.
const CONTRAST: [[(f64, f64); 2]; 3] = [
    [(1.0, 0.0047), (0.0, 0.00001)],
    [(1.0, 0.0053), (0.0, 0.00001)],
    [(34.1, 0.04), (13.5, 0.025)],
];

/// A channel as its contrast sensitivity lets it through.
fn blurred(
    plane: &[f64],
    width: usize,
    contrast: [(f64, f64); 2],
    pixels_per_degree: f64,
) -> Vec<f64> {
    let sigma = |b: f64| (b / (2.0 * PI * PI)).sqrt() * pixels_per_degree;
    // That of the widest channel, for all.
    let radius = (3.0 * sigma(0.04)).ceil() as usize;
    let weight = |(a, b): (f64, f64)| a * (PI / b).sqrt() * square(radius, sigma(b));
    let sum: f64 = contrast.into_iter().map(weight).sum();
    let mut blurred = vec![0.0; plane.len()];
    for (a, b) in contrast.into_iter().filter(|(a, _)| *a > 0.0) {
        let (row, part) = (Row::gaussian(radius, sigma(b)), weight((a, b)) / sum);
        let through = filtered(plane, width, &row, &row);
        blurred.iter_mut().zip(through).for_each(|(sum, v)| *sum += part * v);
    }
    blurred
}

/// The sum of a Gaussian of height 1 over the pixels of a square.
fn square(radius: usize, sigma: f64) -> f64 {
    let radius = radius as i32;
    let line = (-radius..=radius).map(|x| (-0.5 * (f64::from(x) / sigma).powi(2)).exp());
    line.sum::<f64>().powi(2)
}

/// How strong the edges and the points of a luminance plane are at each pixel.
fn features(luminance: &[f64], width: usize, pixels_per_degree: f64) -> [Vec<f64>; 2] {
    let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as usize;
    let gaussian = Row::gaussian(radius, sigma);
    [Row::edge(radius, sigma), Row::point(radius, sigma)].map(|row| {
        let across = filtered(luminance, width, &row, &gaussian);
        let down = filtered(luminance, width, &gaussian, &row);
        across.iter().zip(&down).map(|(x, y)| x.hypot(*y)).collect()
    })
}

/// The largest color difference, that of green and blue.
fn most() -> f64 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
    hyab(green, blue).powf(COLOR_EXPONENT)
}

/// A color difference as an error from 0 to 1: the smaller ones get most of the range.
fn redistributed(difference: f64, most: f64) -> f64 {
    let knee = KNEE * most;
    if difference < knee {
        return KNEE_ERROR / knee * difference;
    }
    KNEE_ERROR + (difference - knee) / (most - knee) * (1.0 - KNEE_ERROR)
}

#[cfg(test)]
mod tests;
