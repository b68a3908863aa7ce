//! See [`conv_head`].

use super::conv3x3::conv3x3;
use super::head::head;
use super::tensor::Tensor;
use crate::Image;
use crate::model::Params;

/// The last 3×3 convolution with ReLU and [`head`] with its sigmoid, one after the other.
///
/// `input` is `[i, h, w]`; `conv` holds a weight `[c, i, 3, 3]` and a bias `[c]`, `params` hold a
/// weight `[3, c]` and a bias `[3]`; the rest is as for [`head`].
///
/// # Panics
/// If a shape does not fit.
#[must_use]
pub fn conv_head(
    input: &Tensor,
    [conv, params]: [&Params; 2],
    input_scale: f32,
    clean: &[bool],
    color: &Image,
) -> Image {
    let tensor = conv3x3(input, &conv.weight, &conv.bias, true);
    head(&tensor, params, true, input_scale, clean, color)
}
