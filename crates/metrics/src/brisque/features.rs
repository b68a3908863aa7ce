//! The 36 features: how a picture's values are distributed around their local mean.

use super::distribution::{asymmetric, symmetric};
use crate::window::Gaussian;

/// The number of features.
pub(super) const COUNT: usize = 36;
/// The shortest side for which the window still fits into the half-size picture.
pub(super) const SMALLEST: usize = 2 * (2 * WINDOW.radius + 1);

const WINDOW: Gaussian = Gaussian { radius: 3, sigma: 7.0 / 6.0 };
/// The range of the values, which the constant 1 in the division goes with.
const LEVELS: f64 = 255.0;
/// A difference from the mean below this is rounding: its sign means nothing, and signs are
/// counted.
const LEAST: f64 = 1e-6;
/// Offsets, down and right, of the neighbors that a value is multiplied by.
const PAIRS: [(usize, isize); 4] = [(0, 1), (1, 0), (1, 1), (1, -1)];

/// Computes the features of luma in `[0, 1]`, at full size, then at half size.
///
/// At each size: shape and variance of the normalized values; then shape, mean, left and right
/// variance of their products along the rows, the columns and the two diagonals.
pub(super) fn features(luma: &[f64], width: usize) -> [f64; COUNT] {
    let levels: Vec<f64> = luma.iter().map(|v| LEVELS * v).collect();
    let mut all = at_one_size(&levels, width);
    all.extend(at_one_size(&half(&levels, width), width / 2));
    all.try_into().expect("18 at either size")
}

/// The mean of each 2×2 pixels, dropping an odd last row or column.
fn half(plane: &[f64], width: usize) -> Vec<f64> {
    let (columns, rows) = (width / 2, plane.len() / width / 2);
    let mean = |i: usize| {
        let corner = i / columns * 2 * width + i % columns * 2;
        let four = [corner, corner + 1, corner + width, corner + width + 1];
        four.iter().map(|&i| plane[i]).sum::<f64>() / 4.0
    };
    (0..columns * rows).map(mean).collect()
}

fn at_one_size(plane: &[f64], width: usize) -> Vec<f64> {
    let normalized = normalized(plane, width);
    let product = |pair| asymmetric(&products(&normalized, width, pair));
    symmetric(&normalized).into_iter().chain(PAIRS.into_iter().flat_map(product)).collect()
}

/// The paper's MSCN coefficients, `(I − mean) / (deviation + 1)`, with mean and deviation over the
/// window.
fn normalized(plane: &[f64], width: usize) -> Vec<f64> {
    let squares: Vec<f64> = plane.iter().map(|v| v * v).collect();
    let (means, mean_squares) = (WINDOW.blurred(plane, width), WINDOW.blurred(&squares, width));
    let value = |((v, mean), mean_square): ((&f64, f64), f64)| {
        let away = v - mean;
        let deviation = (mean_square - mean * mean).max(0.0).sqrt();
        if away.abs() < LEAST { 0.0 } else { away / (deviation + 1.0) }
    };
    plane.iter().zip(means).zip(mean_squares).map(value).collect()
}

/// The product of each value and its neighbor, for pairs within the picture.
fn products(plane: &[f64], width: usize, (down, right): (usize, isize)) -> Vec<f64> {
    let columns = right.min(0).unsigned_abs()..width - right.max(0).unsigned_abs();
    let rows = plane.chunks_exact(width).zip(plane.chunks_exact(width).skip(down));
    let pair = |(row, below): (&[f64], &[f64])| {
        let product = |x: usize| row[x] * below[x.saturating_add_signed(right)];
        columns.clone().map(product).collect::<Vec<_>>()
    };
    rows.flat_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_pair_each_neighbor_once() {
        let plane = [1.0, 2.0, 3.0, 5.0, 7.0, 11.0];
        let of = |pair| products(&plane, 3, pair);
        assert_eq!(of(PAIRS[0]), [2.0, 6.0, 35.0, 77.0]);
        assert_eq!(of(PAIRS[1]), [5.0, 14.0, 33.0]);
        assert_eq!(of(PAIRS[2]), [7.0, 22.0]);
        assert_eq!(of(PAIRS[3]), [10.0, 21.0]);
    }

    #[test]
    fn half_the_size_is_the_mean_of_four_and_drops_an_odd_end() {
        let plane: Vec<f64> = (0..15).map(f64::from).collect();
        assert_eq!(half(&plane, 5), [3.0, 5.0]);
    }

    #[test]
    fn even_surroundings_normalize_to_zero() {
        let plane: Vec<f64> = (0..40 * 20).map(|i| if i % 40 < 20 { 0.1 } else { 77.7 }).collect();
        let found = normalized(&plane, 40);
        assert!(found[..17].iter().chain(&found[23..40]).all(|&v| v == 0.0));
        assert!(
            found[17] < 0.0 && found[22] > 0.0,
            "the window reaches three pixels over the edge"
        );
    }

    #[test]
    fn any_picture_has_finite_features() {
        let checkers = |i: usize| if (i / 16 + i % 16).is_multiple_of(2) { 1.0 } else { 0.0 };
        let spot = |i: usize| if i == 100 { 1.0 } else { 0.0 };
        for picture in [|_| 0.3, checkers, spot] {
            let luma: Vec<f64> = (0..16 * 14).map(picture).collect();
            assert!(features(&luma, 16).iter().all(|v| v.is_finite()));
        }
    }
}
