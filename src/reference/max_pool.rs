//! Downsampling, as `torch.nn.MaxPool2d(2)`.

use super::tensor::Tensor;
use crate::model::Params;

/// The largest of each 2×2 pixels: `[c, h, w]` becomes `[c, h / 2, w / 2]`.
///
/// # Panics
/// If a side is odd.
#[must_use]
pub fn max_pool(input: &Tensor) -> Tensor {
    assert!(
        input.height.is_multiple_of(2) && input.width.is_multiple_of(2),
        "pooling needs even sides, found {}×{}",
        input.width,
        input.height
    );
    Tensor::from_fn(input.channels, input.height / 2, input.width / 2, |c, y, x| {
        let row = |y| input.at(c, y, 2 * x).max(input.at(c, y, 2 * x + 1));
        row(2 * y).max(row(2 * y + 1))
    })
}

/// [`max_pool`] as a layer.
pub(super) fn apply(_: &Params, inputs: &[&Tensor]) -> Tensor {
    max_pool(inputs[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_four_wins_wherever_it_stands() {
        #[rustfmt::skip]
        let input = Tensor::new(2, 2, 4, vec![
             9.0,  1.0,  2.0,  8.0,
             3.0,  4.0,  5.0,  6.0,

            -3.0, -2.0, -9.0, -8.0,
            -1.0, -4.0, -7.0, -6.0,
        ]);
        assert_eq!(max_pool(&input), Tensor::new(2, 1, 2, vec![9.0, 8.0, -1.0, -6.0]));
    }

    #[test]
    fn rows_and_columns_both_halve() {
        let input = Tensor::from_fn(1, 4, 2, |_, y, x| (2 * y + x) as f32);
        assert_eq!(max_pool(&input), Tensor::new(1, 2, 1, vec![3.0, 7.0]));
    }
}
