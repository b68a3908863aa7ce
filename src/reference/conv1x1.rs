//! 1×1 convolution, as `torch.nn.Conv2d(…, kernel_size=1)`.

use super::tensor::Tensor;
use crate::model::Params;

/// Mixes the channels of each pixel: `result(o, y, x) = bias(o) + Σ weight(o, i) · input(i, y, x)`.
///
/// `input` is `[in, h, w]`, `weight` is `[out, in, 1, 1]`, `bias` is `[out]`; the result is
/// `[out, h, w]`.
///
/// # Panics
/// If the number of weights is not `out · in`.
#[must_use]
pub fn conv1x1(input: &Tensor, weight: &[f32], bias: &[f32]) -> Tensor {
    assert_eq!(weight.len(), bias.len() * input.channels, "weights of a 1×1 convolution");
    Tensor::from_fn(bias.len(), input.height, input.width, |o, y, x| {
        let mut sum = f64::from(bias[o]);
        for i in 0..input.channels {
            sum += f64::from(weight[o * input.channels + i]) * f64::from(input.at(i, y, x));
        }
        sum as f32
    })
}

/// [`conv1x1`] as a layer.
pub(super) fn apply(params: &Params, inputs: &[&Tensor]) -> Tensor {
    conv1x1(inputs[0], &params.weight, &params.bias)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_is_a_matrix_times_its_channels() {
        let input = Tensor::new(2, 1, 2, vec![1.0, 2.0, 3.0, 4.0]);
        let weight = [1.0, 10.0, 100.0, 1000.0, -1.0, 0.0];
        let expected = vec![31.0, 42.0, 3100.5, 4200.5, -1.0, -2.0];
        assert_eq!(conv1x1(&input, &weight, &[0.0, 0.5, 0.0]), Tensor::new(3, 1, 2, expected));
    }
}
