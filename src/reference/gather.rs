//! The result of a kernel pyramid: see [`gather`] and [`kernel_pyramid`].

use super::contrast::{contrast, modulated, texture};
use super::pyramid::{Light, finest, pyramid, weight};
use super::tensor::Tensor;
use crate::image::Image;

/// Channel of the logits with the share's logarithm.
const SHARE: usize = 10;

/// A level's result: the sum of the 3×3 pixels around each, by the softmax of the first nine
/// logits, plus the share times the coarser result, bilinearly upsampled by 2.
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

/// The image that a kernel pyramid makes of the noisy color: down the pyramid, and back up gathering
/// at every level. The sums of weighted colors are divided by the sums of weights at the end, where
/// no weight gives black.
///
/// `logits` are those of every level, `[11, h, w]` at full resolution and `[10, …]` at the bottom.
/// `color` is repaired; the pixels that are not `valid` do not count. With an `albedo` in `[0, 1]` and
/// a twelfth logit at full resolution, the result is multiplied by its [`texture`].
///
/// After Bako et al., "Kernel-Predicting Convolutional Networks for Denoising Monte Carlo
/// Renderings" (2017), and Vogels et al., "Denoising with Kernel Prediction and Asymmetric Loss
/// Functions" (2018).
///
/// # Panics
/// Panics if the shapes do not match or there are no levels.
#[must_use]
pub fn kernel_pyramid(
    logits: &[Tensor],
    color: &Image,
    valid: &[bool],
    albedo: Option<&Image>,
) -> Image {
    let contrast = albedo.map(|albedo| contrast(albedo, valid, logits));
    let texture = texture(contrast.as_ref(), &logits[0]);
    let light = gathered(finest(color, valid, &logits[0]), logits);
    image(&modulated(&light, &texture), color.size())
}

/// The sums of full resolution that the logits of all levels make of level 0.
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

fn image(light: &Light, (width, height): (u32, u32)) -> Image {
    let pixel = |i: u32| {
        let [r, g, b, weight] = light.at(i64::from(i % width), i64::from(i / width));
        let divisor = if weight == 0.0 { 1.0 } else { weight };
        [r, g, b].map(|v| (v / divisor).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
    };
    Image::new(width, height, (0..width * height).map(pixel).collect()).expect("the sizes match")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Logits of random-looking values for two levels of 4×4 and 2×2 pixels.
    fn logits() -> Vec<Tensor> {
        let value = |c, y, x| ((c * 7 + y * 5 + x * 3) % 11) as f32 / 4.0 - 1.0;
        vec![Tensor::from_fn(11, 4, 4, value), Tensor::from_fn(10, 2, 2, value)]
    }

    fn ramp() -> Image {
        let pixels = (0..16u8).map(|i| [f32::from(i), 1.0, 100.0 - f32::from(i)]).collect();
        Image::new(4, 4, pixels).expect("a valid image")
    }

    #[test]
    fn a_constant_stays() {
        let image = Image::filled(4, 4, [0.25, 3.0, 1e5]).expect("a valid image");
        let found = kernel_pyramid(&logits(), &image, &[true; 16], None);
        for (found, expected) in
            found.pixels().iter().flatten().zip([0.25, 3.0, 1e5].iter().cycle())
        {
            assert!((found / expected - 1.0).abs() < 1e-6, "found {found}, expected {expected}");
        }
    }

    #[test]
    fn results_of_layers_add_up() {
        let half = |odd: usize| {
            let mut image = ramp();
            let pixels = image.pixels_mut().iter_mut().enumerate();
            pixels.filter(|(i, _)| i % 2 == odd).for_each(|(_, pixel)| *pixel = [0.0; 3]);
            kernel_pyramid(&logits(), &image, &[true; 16], None)
        };
        let [even, odd, whole] =
            [half(0), half(1), kernel_pyramid(&logits(), &ramp(), &[true; 16], None)];
        for ((a, b), whole) in even.pixels().iter().zip(odd.pixels()).zip(whole.pixels()) {
            for c in 0..3 {
                assert!((a[c] + b[c] - whole[c]).abs() < 1e-4, "{a:?} + {b:?}, not {whole:?}");
            }
        }
    }

    #[test]
    fn a_missing_pixel_does_not_count_and_without_any_the_result_is_black() {
        let mut image = Image::filled(4, 4, [2.0; 3]).expect("a valid image");
        image.pixels_mut()[5] = [1e9; 3];
        let mut valid = [true; 16];
        valid[5] = false;
        let found = kernel_pyramid(&logits(), &image, &valid, None);
        assert!(found.pixels().iter().flatten().all(|v| (v - 2.0).abs() < 1e-6), "{found:?}");
        let none = kernel_pyramid(&logits(), &image, &[false; 16], None);
        assert!(none.pixels().iter().flatten().all(|&v| v == 0.0));
    }

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
