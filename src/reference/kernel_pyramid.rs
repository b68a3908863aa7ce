//! The image that a kernel pyramid makes: see [`kernel_pyramid`].

use super::demodulation::{modulated, texture};
use super::gather::gathered;
use super::pyramid::{Light, finest};
use super::tensor::Tensor;
use crate::image::Image;

/// Filters the noisy color with a kernel pyramid: down the pyramid, then back up, gathering at
/// every level. At the end, sums of weighted colors are divided by the sums of weights; without any
/// weight, the result is black.
///
/// `logits` has the logits of every level, `[11, h, w]` at full resolution and `[10, …]` at the
/// bottom. `color` is repaired; pixels that are not `valid` do not count. With an `albedo` in
/// `[0, 1]` and a twelfth logit at full resolution, the result is multiplied by its [`texture`].
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
    let light = gathered(finest(color, valid, &logits[0]), logits);
    let light = match albedo {
        Some(albedo) => modulated(&light, &texture(albedo, valid, logits)),
        None => light,
    };
    image(&light, color.size())
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
}
