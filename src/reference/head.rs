//! See [`head`].

use super::conv1x1::conv1x1;
use super::output_process::output_process;
use super::repair::luminance;
use super::tensor::Tensor;
use crate::Image;
use crate::model::Params;

/// The end of the network: 1×1 convolution, sigmoid if `sigmoid`, then [`output_process`]. Clean
/// blocks are [kept](keep_clean).
///
/// `input` is `[c, h, w]`, `params` hold a weight `[3, c]` and a bias `[3]`, `clean` has a flag per
/// block, row by row, and `color` has the size of the result.
///
/// # Panics
/// Panics if the shapes do not match.
#[must_use]
pub fn head(
    input: &Tensor,
    params: &Params,
    sigmoid: bool,
    input_scale: f32,
    clean: &[bool],
    color: &Image,
) -> Image {
    let sums = conv1x1(input, &params.weight, &params.bias);
    let network = if sigmoid { super::sigmoid(&sums) } else { sums };
    let result = output_process(&network, input_scale, color.width(), color.height());
    keep_clean(result, color, clean, input.width.div_ceil(16))
}

/// Puts the noisy color into the result's clean blocks of 16×16 pixels. There, negative values
/// become 0 if the luminance is negative; all else is unchanged. `clean` has a flag per block, in
/// rows of `columns`.
///
/// # Panics
/// Panics if there are fewer flags than blocks, or the sizes differ.
#[must_use]
pub fn keep_clean(mut result: Image, color: &Image, clean: &[bool], columns: usize) -> Image {
    let width = color.width() as usize;
    for (i, pixel) in result.pixels_mut().iter_mut().enumerate() {
        if clean[i / width / 16 * columns + i % width / 16] {
            let noisy = color.pixels()[i];
            *pixel = if luminance(noisy) < 0.0 { noisy.map(|v| v.max(0.0)) } else { noisy };
        }
    }
    result
}
