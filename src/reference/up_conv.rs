//! See [`up_conv`].

use super::concat::concat;
use super::conv_transpose::conv_transpose;
use super::conv3x3::conv3x3;
use super::tensor::Tensor;
use crate::model::Params;

/// A 3×3 convolution over the skip and, behind it, the upsampled low-resolution tensor: the
/// three plain operators one after the other.
///
/// `skip` is `[s, 2h, 2w]`, `low` is `[l, h, w]`; `params` hold first the transposed
/// convolution's weight `[l, ups, 2, 2]` and bias `[ups]`, then the convolution's weight
/// `[out, s + ups, 3, 3]` and bias `[out]`; the result is `[out, 2h, 2w]`.
///
/// # Panics
/// If a shape does not fit.
#[must_use]
pub fn up_conv(skip: &Tensor, low: &Tensor, params: &Params, ups: usize, relu: bool) -> Tensor {
    let (up_weight, weight) = params.weight.split_at(low.channels * ups * 4);
    let (up_bias, bias) = params.bias.split_at(ups);
    let up = conv_transpose(low, up_weight, up_bias);
    conv3x3(&concat(skip, &up), weight, bias, relu)
}

/// [`up_conv`] as a layer.
pub(super) fn apply(params: &Params, inputs: &[&Tensor], ups: usize, relu: bool) -> Tensor {
    up_conv(inputs[0], inputs[1], params, ups, relu)
}
