//! The albedo's contrast and the texture of light: see [`contrast`], [`texture`] and [`modulated`].

use super::gather::gathered;
use super::pyramid::{Light, finest};
use super::tensor::Tensor;
use crate::image::Image;

/// Added to the albedo, so that noise in black is not texture.
const FLOOR: f64 = 0.05;
/// The logit of the power of the contrast.
const POWER: usize = 11;
/// Gain of that logit.
const GAIN: f64 = 8.0;

/// The logarithm of the ratio of each pixel's albedo to the mean that the kernel pyramid gathers,
/// with 0.05 added to both: `[3, h, w]` with the size of the finest logits, from −3.05 to 3.05.
///
/// `albedo` is in `[0, 1]`. Pixels whose color is not `valid` do not count; where no other pixel
/// counts, the contrast is 0. `logits` are as for [`kernel_pyramid`](fn@super::kernel_pyramid).
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn contrast(albedo: &Image, valid: &[bool], logits: &[Tensor]) -> Tensor {
    let light = gathered(finest(albedo, valid, &logits[0]), logits);
    let (width, height) = (albedo.width() as usize, albedo.height() as usize);
    Tensor::from_fn(3, logits[0].height, logits[0].width, |c, y, x| {
        let own = f64::from(albedo.pixels()[y.min(height - 1) * width + x.min(width - 1)][c]);
        let pixel = light.pixels[y * light.width + x];
        let mean = if pixel[3] == 0.0 { own } else { pixel[c] / pixel[3] };
        ((own + FLOOR) / (mean + FLOOR)).ln() as f32
    })
}

/// The factor by which its surface's texture brightens each pixel, row by row:
/// `exp(power · contrast)` with the predicted power, or 1 without a contrast.
///
/// # Panics
/// Panics if the contrast is smaller than the logits, which are `[12, h, w]` then.
#[must_use]
pub fn texture(contrast: Option<&Tensor>, logits: &Tensor) -> Vec<[f64; 3]> {
    let at = |contrast: &Tensor, i: usize| {
        let (x, y) = (i % logits.width, i / logits.width);
        let power = 1.0 / (1.0 + (-GAIN * f64::from(logits.at(POWER, y, x))).exp());
        [0, 1, 2].map(|c| (power * f64::from(contrast.at(c, y, x))).exp())
    };
    let pixels = 0..logits.width * logits.height;
    pixels.map(|i| contrast.map_or([1.0; 3], |contrast| at(contrast, i))).collect()
}

/// Light multiplied by its texture.
#[must_use]
pub fn modulated(light: &Light, texture: &[[f64; 3]]) -> Light {
    let pixel =
        |(&[r, g, b, weight], t): (&[f64; 4], &[f64; 3])| [r * t[0], g * t[1], b * t[2], weight];
    Light { pixels: light.pixels.iter().zip(texture).map(pixel).collect(), ..*light }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One level whose kernel takes the pixel at the left, or at the edge the pixel itself.
    fn left() -> [Tensor; 1] {
        [Tensor::from_fn(12, 1, 3, |c, _, _| if c == 3 { 99.0 } else { 0.0 })]
    }

    #[test]
    fn a_pixel_is_compared_with_what_is_gathered_by_hand() {
        let albedo = Image::new(3, 1, vec![[0.0; 3], [0.45, 0.2, 0.0], [0.95, 0.2, 0.0]]);
        let found = contrast(&albedo.expect("a valid image"), &[true; 3], &left());
        let expected = [[0.0, 0.0, 0.0], [10_f64.ln(), 5_f64.ln(), 0.0], [2_f64.ln(), 0.0, 0.0]];
        for (x, expected) in expected.iter().enumerate() {
            for (c, expected) in expected.iter().enumerate() {
                assert!((f64::from(found.at(c, 0, x)) - expected).abs() < 1e-6, "{x}: {found:?}");
            }
        }
    }

    #[test]
    fn the_albedo_of_a_pixel_without_color_does_not_count() {
        let albedo = Image::new(3, 1, vec![[0.45; 3], [0.95; 3], [0.45; 3]]);
        let albedo = albedo.expect("a valid image");
        let even = [Tensor::from_fn(12, 1, 3, |_, _, _| 0.0)];
        let found = contrast(&albedo, &[true, false, true], &even);
        for (x, expected) in [0.0, 2_f64.ln(), 0.0].into_iter().enumerate() {
            assert!((f64::from(found.at(0, 0, x)) - expected).abs() < 1e-6, "{x}: {found:?}");
        }
    }

    #[test]
    fn the_power_is_the_sigmoid_of_eight_times_the_logit() {
        let contrast = Tensor::from_fn(3, 1, 3, |c, _, _| [0.0, 1.0, -2.0][c]);
        let logits =
            Tensor::from_fn(12, 1, 3, |c, _, x| if c == 11 { [-99.0, 0.0, 99.0][x] } else { 7.0 });
        let found = texture(Some(&contrast), &logits);
        for (found, power) in found.iter().zip([0.0, 0.5, 1.0]) {
            let expected = [0.0, power, -2.0 * power].map(f64::exp);
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-12), "{found:?}");
        }
        assert_eq!(texture(None, &logits), [[1.0; 3]; 3]);
        let light = Light { width: 3, height: 1, pixels: vec![[2.0, 2.0, 2.0, 0.5]; 3] };
        let expected = [2.0, 2.0 * 1_f64.exp(), 2.0 * (-2_f64).exp(), 0.5];
        let [.., last] = modulated(&light, &found).pixels[..] else { unreachable!() };
        assert!(last.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{last:?}");
    }
}
