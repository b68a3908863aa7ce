//! Learned upsampling, as `torch.nn.ConvTranspose2d(…, kernel_size=2, stride=2)`.

use super::tensor::Tensor;
use crate::model::Params;

/// Spreads each pixel over the 2×2 pixels it becomes, which never overlap:
/// `result(o, y, x) = bias(o) + Σ weight(i, o, y mod 2, x mod 2) · input(i, y / 2, x / 2)`.
///
/// `input` is `[in, h, w]`, `weight` is `[in, out, 2, 2]` (input channel first, unlike a
/// convolution), `bias` is `[out]`; the result is `[out, 2h, 2w]`.
///
/// # Panics
/// If the number of weights is not `in · out · 4`.
#[must_use]
pub fn conv_transpose(input: &Tensor, weight: &[f32], bias: &[f32]) -> Tensor {
    let out = bias.len();
    assert_eq!(weight.len(), input.channels * out * 4, "weights of a transposed convolution");
    Tensor::from_fn(out, 2 * input.height, 2 * input.width, |o, y, x| {
        let mut sum = f64::from(bias[o]);
        for i in 0..input.channels {
            let w = weight[((i * out + o) * 2 + y % 2) * 2 + x % 2];
            sum += f64::from(w) * f64::from(input.at(i, y / 2, x / 2));
        }
        sum as f32
    })
}

/// [`conv_transpose`] as a layer.
pub(super) fn apply(params: &Params, inputs: &[&Tensor]) -> Tensor {
    conv_transpose(inputs[0], &params.weight, &params.bias)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_becomes_its_multiple_of_the_kernel() {
        let input = Tensor::new(1, 1, 2, vec![1.0, 10.0]);
        #[rustfmt::skip]
        let expected = vec![
            1.5, 2.5, 10.5, 20.5,
            3.5, 4.5, 30.5, 40.5,
        ];
        let found = conv_transpose(&input, &[1.0, 2.0, 3.0, 4.0], &[0.5]);
        assert_eq!(found, Tensor::new(1, 2, 4, expected));
    }

    #[test]
    fn weights_are_input_channel_first() {
        let input = Tensor::new(2, 1, 1, vec![2.0, 3.0]);
        let weight: Vec<f32> =
            [1.0, 10.0, 100.0, 100.0, 1000.0, 10000.0].iter().flat_map(|&w| [w; 4]).collect();
        let found = conv_transpose(&input, &weight, &[0.0; 3]);
        let expected = [302.0, 3020.0, 30200.0].iter().flat_map(|&v| [v; 4]).collect();
        assert_eq!(found, Tensor::new(3, 2, 2, expected));
    }
}
