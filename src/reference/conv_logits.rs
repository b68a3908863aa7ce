//! See [`conv_logits`].

use super::conv1x1::conv1x1;
use super::conv3x3::conv3x3;
use super::tensor::Tensor;
use crate::model::Params;

/// A 3×3 convolution with ReLU that keeps the number of channels, then a 1×1 convolution: the two
/// plain operators in sequence.
///
/// `input` is `[c, h, w]`; `params` hold the first convolution's weight `[c, c, 3, 3]` and bias
/// `[c]`, followed by the second's, `[out, c, 1, 1]` and `[out]`; the result is `[out, h, w]`.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn conv_logits(input: &Tensor, params: &Params) -> Tensor {
    let (weight, logits) = params.weight.split_at(9 * input.channels * input.channels);
    let (bias, logits_bias) = params.bias.split_at(input.channels);
    conv1x1(&conv3x3(input, weight, bias, true), logits, logits_bias)
}

/// [`conv_logits`] as a layer.
pub(super) fn apply(params: &Params, inputs: &[&Tensor]) -> Tensor {
    conv_logits(inputs[0], params)
}
