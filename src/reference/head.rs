//! See [`head`].

use super::{Tensor, conv1x1, fill, output_process};
use crate::Image;
use crate::model::Params;

/// The end of the network: 1×1 convolution, sigmoid if `sigmoid`, and [`output_process`], one after
/// the other; in clean blocks of 16×16 pixels the noisy colour as it was, [filled](fill) and without
/// negative values.
///
/// `input` is `[c, h, w]`, `params` hold a weight `[3, c]` and a bias `[3]`, `clean` has a flag
/// per block, row by row, and `color` has the size of the result.
///
/// # Panics
/// If a shape does not fit.
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
    let mut result = output_process(&network, input_scale, color.width(), color.height());
    let noisy = fill(color);
    let blocks = input.width.div_ceil(16);
    for (i, pixel) in result.pixels_mut().iter_mut().enumerate() {
        let (x, y) = (i % color.width() as usize, i / color.width() as usize);
        if clean[y / 16 * blocks + x / 16] {
            *pixel = noisy.pixels()[i].map(|v| v.max(0.0));
        }
    }
    result
}
