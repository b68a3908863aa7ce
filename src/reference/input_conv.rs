//! See [`input_conv`].

use super::conv3x3::conv3x3;
use super::input_process::input_process;
use super::tensor::Tensor;
use crate::Image;
use crate::model::Params;

/// [`input_process`] and the first 3×3 convolution with ReLU, one after the other.
///
/// `auxiliary` are albedo and normal, if they are there; `params` hold a weight `[c, i, 3, 3]` and a
/// bias `[c]`, for three inputs `i` per image.
///
/// # Panics
/// If a shape does not fit.
#[must_use]
pub fn input_conv(
    color: &Image,
    auxiliary: [Option<&Image>; 2],
    params: &Params,
    input_scale: f32,
    alignment: u32,
) -> Tensor {
    let [albedo, normal] = auxiliary;
    let input = input_process(color, albedo, normal, input_scale, alignment);
    conv3x3(&input, &params.weight, &params.bias, true)
}
