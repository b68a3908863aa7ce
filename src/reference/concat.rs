//! The skip connection, as `torch.cat((first, second), dim=1)`.

use super::tensor::Tensor;
use crate::model::Params;

/// The channels of `first`, then those of `second`: `[a, h, w]` and `[b, h, w]` become
/// `[a + b, h, w]`.
///
/// # Panics
/// If the two differ in height or width.
#[must_use]
pub fn concat(first: &Tensor, second: &Tensor) -> Tensor {
    let (height, width) = (first.height, first.width);
    assert_eq!((height, width), (second.height, second.width), "sides of concatenated tensors");
    Tensor::from_fn(first.channels + second.channels, height, width, |c, y, x| {
        if c < first.channels { first.at(c, y, x) } else { second.at(c - first.channels, y, x) }
    })
}

/// [`concat`] as a layer.
pub(super) fn apply(_: &Params, inputs: &[&Tensor]) -> Tensor {
    concat(inputs[0], inputs[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_tensors_channels_stand_first() {
        let first = Tensor::new(1, 1, 2, vec![1.0, 2.0]);
        let second = Tensor::new(2, 1, 2, vec![3.0, 4.0, 5.0, 6.0]);
        let expected = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(concat(&first, &second), Tensor::new(3, 1, 2, expected));
    }
}
