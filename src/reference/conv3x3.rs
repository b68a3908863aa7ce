//! 3×3 convolution: `torch.nn.Conv2d(…, kernel_size=3, padding=1)`.

use super::tensor::Tensor;
use crate::model::Params;

/// Convolves with 3×3 kernels over a border of zeros, adds the bias, and with `relu` sets negative
/// results to 0. As in every deep-learning framework, this is a correlation: the kernel is not
/// flipped.
///
/// `input` is `[in, h, w]`, `weight` is `[out, in, 3, 3]`, `bias` is `[out]`; the result is `[out,
/// h, w]` with `result(o, y, x) = bias(o) + Σ weight(o, i, ky, kx) · input(i, y + ky − 1, x + kx −
/// 1)`.
///
/// # Panics
/// Panics if the number of weights is not `out · in · 9`.
#[must_use]
pub fn conv3x3(input: &Tensor, weight: &[f32], bias: &[f32], relu: bool) -> Tensor {
    assert_eq!(weight.len(), bias.len() * input.channels * 9, "weights of a 3×3 convolution");
    Tensor::from_fn(bias.len(), input.height, input.width, |o, y, x| {
        let mut sum = f64::from(bias[o]);
        for i in 0..input.channels {
            for ky in 0..3 {
                for kx in 0..3 {
                    let w = weight[((o * input.channels + i) * 3 + ky) * 3 + kx];
                    sum += f64::from(w) * zero_padded(input, i, y + ky, x + kx);
                }
            }
        }
        if relu && sum < 0.0 { 0.0 } else { sum as f32 }
    })
}

/// The value at `(c, y, x)` of the input with a border of one zero on all four sides.
fn zero_padded(input: &Tensor, c: usize, y: usize, x: usize) -> f64 {
    let inside = (1..=input.height).contains(&y) && (1..=input.width).contains(&x);
    if inside { f64::from(input.at(c, y - 1, x - 1)) } else { 0.0 }
}

/// [`conv3x3`] as a layer.
pub(super) fn apply(params: &Params, inputs: &[&Tensor], relu: bool) -> Tensor {
    conv3x3(inputs[0], &params.weight, &params.bias, relu)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impulse_shows_the_kernel_turned_by_half_a_turn() {
        let impulse = Tensor::from_fn(1, 3, 4, |_, y, x| if (y, x) == (1, 2) { 1.0 } else { 0.0 });
        let weight: Vec<f32> = (1..=9u8).map(f32::from).collect();
        #[rustfmt::skip]
        let expected = vec![
            0.0, 9.0, 8.0, 7.0,
            0.0, 6.0, 5.0, 4.0,
            0.0, 3.0, 2.0, 1.0,
        ];
        assert_eq!(conv3x3(&impulse, &weight, &[0.0], true), Tensor::new(1, 3, 4, expected));
    }

    #[test]
    fn outside_of_the_image_is_zero() {
        let ones = Tensor::from_fn(1, 3, 3, |_, _, _| 1.0);
        let expected = vec![4.0, 6.0, 4.0, 6.0, 9.0, 6.0, 4.0, 6.0, 4.0];
        assert_eq!(conv3x3(&ones, &[1.0; 9], &[0.0], false).data, expected);
    }

    #[test]
    fn weights_are_output_channel_first() {
        let input = Tensor::new(2, 1, 1, vec![2.0, 3.0]);
        let mut weight = vec![7.0; 36];
        for (pair, center) in [1.0, 10.0, 100.0, 1000.0].into_iter().enumerate() {
            weight[pair * 9 + 4] = center;
        }
        assert_eq!(conv3x3(&input, &weight, &[0.5, -0.5], false).data, [32.5, 3199.5]);
    }

    #[test]
    fn only_relu_removes_negative_results() {
        let input = Tensor::new(1, 1, 1, vec![1.0]);
        assert_eq!(conv3x3(&input, &[-1.0; 9], &[0.25], false).data, [-0.75]);
        assert_eq!(conv3x3(&input, &[-1.0; 9], &[0.25], true).data, [0.0]);
    }
}
