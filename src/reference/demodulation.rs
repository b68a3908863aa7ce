//! The texture that demodulation returns to gathered light: see [`texture`] and [`modulated`].

use super::gather::gathered;
use super::pyramid::{Light, finest};
use super::tensor::Tensor;
use crate::image::Image;

/// Added to the albedo, so that noise in black is not texture.
const FLOOR: f64 = 0.05;
/// The logit of the power.
const POWER: usize = 11;
/// Gain of that logit.
const GAIN: f64 = 8.0;

/// The factor by which its surface's texture brightens each pixel, row by row with the size of the
/// finest logits: the ratio of the pixel's albedo to the mean that the kernel pyramid gathers, with
/// 0.05 added to both, raised to the predicted power. From 1/21 to 21.
///
/// `albedo` is in `[0, 1]`. Pixels whose color is not `valid` do not count; where no other pixel
/// counts, the factor is 1. `logits` are as for [`kernel_pyramid`](fn@super::kernel_pyramid), with
/// twelve at full resolution.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn texture(albedo: &Image, valid: &[bool], logits: &[Tensor]) -> Vec<[f64; 3]> {
    let light = gathered(finest(albedo, valid, &logits[0]), logits);
    let (width, height) = (albedo.width() as usize, albedo.height() as usize);
    let factor = |i: usize| {
        let (x, y) = (i % light.width, i / light.width);
        let power = 1.0 / (1.0 + (-GAIN * f64::from(logits[0].at(POWER, y, x))).exp());
        let own = albedo.pixels()[y.min(height - 1) * width + x.min(width - 1)].map(f64::from);
        let weight = light.pixels[i][3];
        [0, 1, 2].map(|c| {
            let mean = if weight == 0.0 { own[c] } else { light.pixels[i][c] / weight };
            ((own[c] + FLOOR) / (mean + FLOOR)).powf(power)
        })
    };
    (0..light.pixels.len()).map(factor).collect()
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

    /// One level of three pixels with these logits of power, whose kernels take the pixel at the
    /// left, or at the edge the pixel itself.
    fn left(power: [f32; 3]) -> [Tensor; 1] {
        let logit = |c, x: usize| match c {
            3 => 99.0,
            POWER => power[x],
            _ => 0.0,
        };
        [Tensor::from_fn(12, 1, 3, |c, _, x| logit(c, x))]
    }

    fn same(found: &[[f64; 3]], expected: &[[f64; 3]]) {
        assert_eq!(found.len(), expected.len());
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_pixel_is_compared_with_what_is_gathered_by_hand() {
        let albedo = Image::new(3, 1, vec![[0.0; 3], [0.45, 0.2, 0.0], [0.95, 0.2, 0.0]]);
        let found = texture(&albedo.expect("a valid image"), &[true; 3], &left([99.0; 3]));
        same(&found, &[[1.0; 3], [10.0, 5.0, 1.0], [2.0, 1.0, 1.0]]);
    }

    #[test]
    fn the_albedo_of_a_pixel_without_color_does_not_count() {
        let albedo = Image::new(3, 1, vec![[0.45; 3], [0.95; 3], [0.45; 3]]);
        let albedo = albedo.expect("a valid image");
        let even = [Tensor::from_fn(12, 1, 3, |c, _, _| if c == POWER { 99.0 } else { 0.0 })];
        same(&texture(&albedo, &[true, false, true], &even), &[[1.0; 3], [2.0; 3], [1.0; 3]]);
        same(&texture(&albedo, &[false; 3], &even), &[[1.0; 3]; 3]);
    }

    #[test]
    fn the_power_is_the_sigmoid_of_eight_times_the_logit() {
        let albedo = Image::new(3, 1, vec![[0.05; 3], [0.35; 3], [0.75; 3]]);
        let logit = 3_f32.ln() / 8.0;
        let found = texture(&albedo.expect("a valid image"), &[true; 3], &left([0.0, 0.0, logit]));
        same(&found, &[[1.0; 3], [2.0; 3], [2_f64.powf(0.75); 3]]);
    }

    #[test]
    fn light_is_multiplied_and_its_weight_is_not() {
        let light = Light { width: 1, height: 1, pixels: vec![[2.0, 4.0, 6.0, 0.5]] };
        let found = modulated(&light, &[[1.0, 0.5, 3.0]]);
        assert_eq!(found.pixels, [[2.0, 2.0, 18.0, 0.5]]);
    }
}
