//! The albedo's contrast and the texture of light: see [`contrast`], [`texture`], [`demodulated`] and
//! [`modulated`].

use super::pyramid::Light;
use super::tensor::Tensor;

/// Added to the albedo, so that noise in black is no contrast.
const FLOOR: f64 = 0.05;
/// Channel of the logits with the power of the contrast.
const POWER: usize = 11;
/// Of the power's logit.
const GAIN: f64 = 8.0;

/// The logarithm of how much brighter each pixel is than its surroundings, both raised by 0.05. The
/// surroundings are the means of aligned blocks of `side` pixels, upsampled as by
/// `torch.nn.functional.interpolate(scale_factor=side, mode="bilinear")`.
///
/// `albedo` is `[3, h, w]` in `[0, 1]`, its sides multiples of `side`; so is the result, from −3.05 to
/// 3.05.
///
/// # Panics
/// Panics if the sides are no multiples of `side`.
#[must_use]
pub fn contrast(albedo: &Tensor, side: usize) -> Tensor {
    let Tensor { channels, height, width, .. } = *albedo;
    assert!(height % side == 0 && width % side == 0, "{width}×{height} has blocks of {side}");
    Tensor::from_fn(channels, height, width, |c, y, x| {
        let mut mean = 0.0;
        for (row, down) in around(y, side, height) {
            for (column, right) in around(x, side, width) {
                mean += down * right * block_mean(albedo, side, [c, row, column]);
            }
        }
        let own = f64::from(albedo.at(c, y, x));
        ((own + FLOOR).ln() - (mean + FLOOR).ln()) as f32
    })
}

fn block_mean(albedo: &Tensor, side: usize, [c, row, column]: [usize; 3]) -> f64 {
    let pixels = (0..side * side).map(|i| [row * side + i / side, column * side + i % side]);
    let sum: f64 = pixels.map(|[y, x]| f64::from(albedo.at(c, y, x))).sum();
    sum / (side * side) as f64
}

/// The two blocks with the nearest centers along an axis, and their shares. Edges repeat.
fn around(at: usize, side: usize, pixels: usize) -> [(usize, f64); 2] {
    let center = (at as f64 + 0.5) / side as f64 - 0.5;
    let (first, share) = (center.floor(), center - center.floor());
    let block = |at: f64| at.clamp(0.0, (pixels / side - 1) as f64) as usize;
    [(block(first), 1.0 - share), (block(first + 1.0), share)]
}

/// How much brighter its surface's texture makes each pixel, row by row: the contrast to the
/// predicted power, or 1 without a contrast.
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

/// Light without its texture.
#[must_use]
pub fn demodulated(light: &Light, texture: &[[f64; 3]]) -> Light {
    map(light, texture, |value, texture| value / texture)
}

/// Light with its texture.
#[must_use]
pub fn modulated(light: &Light, texture: &[[f64; 3]]) -> Light {
    map(light, texture, |value, texture| value * texture)
}

fn map(light: &Light, texture: &[[f64; 3]], of: fn(f64, f64) -> f64) -> Light {
    let pixel = |(&[r, g, b, weight], t): (&[f64; 4], &[f64; 3])| {
        [of(r, t[0]), of(g, t[1]), of(b, t[2]), weight]
    };
    Light { pixels: light.pixels.iter().zip(texture).map(pixel).collect(), ..*light }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_constant_has_no_contrast() {
        let gray = Tensor::from_fn(3, 16, 8, |c, _, _| [0.0, 0.3, 1.0][c]);
        assert_eq!(contrast(&gray, 8).data, [0.0; 3 * 16 * 8]);
    }

    /// Blocks of means 0, 0.4 and 0.8: pixel 3 lies a quarter before the center of the second.
    #[test]
    fn means_are_upsampled_between_the_centers_of_blocks() {
        let value = |x: usize| [0.0_f64, 0.4, 0.8][x / 2];
        let ramp = Tensor::from_fn(3, 2, 6, |_, _, x| value(x) as f32);
        let found = contrast(&ramp, 2);
        for (x, mean) in [0.0, 0.1, 0.3, 0.5, 0.7, 0.8].into_iter().enumerate() {
            let expected = (value(x) + 0.05).ln() - f64::ln(mean + 0.05);
            assert!((f64::from(found.at(1, 1, x)) - expected).abs() < 1e-6, "{x}: {found:?}");
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
        let [_, g, b, weight] = demodulated(&light, &found).pixels[2];
        assert!((g * 1_f64.exp() - 2.0).abs() < 1e-12 && (b * (-2_f64).exp() - 2.0).abs() < 1e-12);
        let back = modulated(&demodulated(&light, &found), &found).pixels[2];
        assert!(weight == 0.5 && (back[2] - 2.0).abs() < 1e-12);
    }
}
