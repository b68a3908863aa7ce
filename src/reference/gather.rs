//! The result of a level of a kernel pyramid: see [`gather`].

use super::pyramid::{Light, pyramid, weight};
use super::tensor::Tensor;

/// The logit that holds the share's logarithm.
const SHARE: usize = 10;

/// A level's result: the sum of the 3×3 pixels around each, weighted by the softmax of the first
/// nine logits, plus the share times the coarser result, bilinearly upsampled by 2.
///
/// `logits` are `[10 or 11, h, w]`, as large as the level; `coarser` has half its sides, or is
/// absent at the bottom, where there is no share.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn gather(level: &Light, logits: &Tensor, coarser: Option<&Light>) -> Light {
    assert_eq!((level.width, level.height), (logits.width, logits.height), "sizes");
    Light::from_fn((level.width, level.height), |x, y| {
        let mut sum = [0.0; 4];
        for (tap, odds) in softmax(logits, x, y).into_iter().enumerate() {
            let near = [tap % 3, tap / 3].map(|i| i as i64 - 1);
            add(&mut sum, level.at(x as i64 + near[0], y as i64 + near[1]), odds);
        }
        if let Some(coarser) = coarser {
            add(&mut sum, upsampled(coarser, x, y), weight(logits.at(SHARE, y, x)));
        }
        sum
    })
}

/// The exponentials of the first nine logits over their sum.
fn softmax(logits: &Tensor, x: usize, y: usize) -> [f64; 9] {
    let taps: [f64; 9] = std::array::from_fn(|tap| f64::from(logits.at(tap, y, x)));
    let most = taps.into_iter().fold(f64::MIN, f64::max);
    let sum: f64 = taps.iter().map(|tap| (tap - most).exp()).sum();
    taps.map(|tap| (tap - most).exp() / sum)
}

/// `torch.nn.functional.interpolate(scale_factor=2, mode="bilinear")` at a pixel of the larger
/// image.
fn upsampled(coarser: &Light, x: usize, y: usize) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (row, down) in around(y) {
        for (column, right) in around(x) {
            add(&mut sum, coarser.at(column, row), down * right);
        }
    }
    sum
}

/// The two nearest pixels of half the resolution along an axis, and their shares.
fn around(at: usize) -> [(i64, f64); 2] {
    let center = (at as f64 - 0.5) / 2.0;
    let (first, share) = (center.floor(), center - center.floor());
    [(first as i64, 1.0 - share), (first as i64 + 1, share)]
}

fn add(sum: &mut [f64; 4], pixel: [f64; 4], factor: f64) {
    for (sum, value) in sum.iter_mut().zip(pixel) {
        *sum += value * factor;
    }
}

/// The result at full resolution, gathered from level 0 with the logits of all levels.
pub(super) fn gathered(level0: Light, logits: &[Tensor]) -> Light {
    let mut levels = vec![level0];
    for logits in &logits[1..] {
        levels.push(pyramid(levels.last().expect("there is one"), logits));
    }
    let mut result: Option<Light> = None;
    for (level, logits) in levels.iter().zip(logits).rev() {
        result = Some(gather(level, logits, result.as_ref()));
    }
    result.expect("there is a level")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: at a corner of a level of one pixel with all weights 1, every tap is that pixel.
    #[test]
    fn a_share_mixes_in_the_coarser_level() {
        let one = |rgb: f64| Light { width: 1, height: 1, pixels: vec![[rgb, rgb, rgb, 1.0]] };
        let mut logits = Tensor::from_fn(11, 1, 1, |_, _, _| 0.0);
        logits.data[10] = 3.0_f32.ln();
        let [r, .., weight] = gather(&one(1.0), &logits, Some(&one(5.0))).pixels[0];
        assert!((weight - 4.0).abs() < 1e-6 && (r / weight - 4.0).abs() < 1e-6, "{r} of {weight}");
    }
}
