//! Nearest upsampling, as `torch.nn.Upsample(scale_factor=2)`.

use super::tensor::Tensor;
use crate::model::Params;

/// Every pixel four times: `[c, h, w]` becomes `[c, 2h, 2w]`.
#[must_use]
pub fn upsample(input: &Tensor) -> Tensor {
    Tensor::from_fn(input.channels, 2 * input.height, 2 * input.width, |c, y, x| {
        input.at(c, y / 2, x / 2)
    })
}

/// [`upsample`] as a layer.
pub(super) fn apply(_: &Params, inputs: &[&Tensor]) -> Tensor {
    upsample(inputs[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_becomes_two_by_two() {
        let input = Tensor::new(2, 1, 2, vec![1.0, 2.0, 3.0, 4.0]);
        #[rustfmt::skip]
        let expected = vec![
            1.0, 1.0, 2.0, 2.0,
            1.0, 1.0, 2.0, 2.0,

            3.0, 3.0, 4.0, 4.0,
            3.0, 3.0, 4.0, 4.0,
        ];
        assert_eq!(upsample(&input), Tensor::new(2, 2, 4, expected));
    }
}
