//! The pyramid of weighted colors: see [`finest`] and [`pyramid`].

use super::tensor::Tensor;
use crate::image::Image;

/// One level of a kernel pyramid. A pixel is `[w·r, w·g, w·b, w]`, a color times its weight, and
/// the weight: like premultiplied alpha, such pixels add up.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// All pixels, row by row.
    pub pixels: Vec<[f64; 4]>,
}

impl Light {
    /// The pixels that `pixel` returns for a column and a row.
    pub(super) fn from_fn(
        (width, height): (usize, usize),
        pixel: impl Fn(usize, usize) -> [f64; 4],
    ) -> Self {
        let place = |i: usize| pixel(i % width, i / width);
        Self { width, height, pixels: (0..width * height).map(place).collect() }
    }

    /// The pixel at a column and a row. Beyond the edges, pixels repeat.
    #[must_use]
    pub fn at(&self, x: i64, y: i64) -> [f64; 4] {
        let clamped = |at: i64, side: usize| at.clamp(0, side as i64 - 1) as usize;
        self.pixels[clamped(y, self.height) * self.width + clamped(x, self.width)]
    }
}

/// The logit that holds the confidence's logarithm.
const CONFIDENCE: usize = 9;
/// Logarithms of confidences and shares are clamped to ± this.
const MOST: f64 = 8.0;

/// The exponential of a logit clamped to ±8.
pub(super) fn weight(logit: f32) -> f64 {
    f64::from(logit).clamp(-MOST, MOST).exp()
}

/// The finest level: the noisy color with its confidence as the weight, 0 where `valid` is not set.
///
/// `color` is repaired, not encoded. `logits` are at least as large; to the right and below, the
/// color's edge repeats.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn finest(color: &Image, valid: &[bool], logits: &Tensor) -> Light {
    let (width, height) = (color.width() as usize, color.height() as usize);
    Light::from_fn((logits.width, logits.height), |x, y| {
        let at = y.min(height - 1) * width + x.min(width - 1);
        let own = weight(logits.at(CONFIDENCE, y, x)) * f64::from(u8::from(valid[at]));
        let [r, g, b] = color.pixels()[at].map(|v| f64::from(v) * own);
        [r, g, b, own]
    })
}

/// The next coarser level: the mean of 2×2 pixels times the level's confidence.
///
/// `logits` are `[10 or 11, h, w]` for `finer` of 2h rows and 2w columns.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn pyramid(finer: &Light, logits: &Tensor) -> Light {
    assert_eq!((finer.width, finer.height), (2 * logits.width, 2 * logits.height), "sizes");
    Light::from_fn((logits.width, logits.height), |x, y| {
        let own = weight(logits.at(CONFIDENCE, y, x)) / 4.0;
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let four = four.map(|(i, j)| finer.pixels[(2 * y + j) * finer.width + 2 * x + i]);
        std::array::from_fn(|c| four.iter().map(|pixel| pixel[c]).sum::<f64>() * own)
    })
}
