//! Logistic function: `torch.sigmoid`.

use super::tensor::Tensor;
use crate::model::Params;

/// `1 / (1 + exp(−v))` of every value, in `[0, 1]`; same shape as the input.
///
/// Far from 0 it saturates: `exp` overflows to infinity, and `1 / ∞` is 0.
#[must_use]
pub fn sigmoid(input: &Tensor) -> Tensor {
    let value = |&v: &f32| (1.0 / (1.0 + (-f64::from(v)).exp())) as f32;
    Tensor { data: input.data.iter().map(value).collect(), ..*input }
}

/// [`sigmoid`] as a layer.
pub(super) fn apply(_: &Params, inputs: &[&Tensor]) -> Tensor {
    sigmoid(inputs[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_and_both_ends() {
        let three = 3.0_f32.ln();
        let input =
            Tensor::new(1, 1, 7, vec![0.0, three, -three, 100.0, -200.0, f32::MAX, f32::MIN]);
        let found = sigmoid(&input);
        assert_eq!(found.shape(), input.shape());
        for (found, expected) in found.data.iter().zip([0.5, 0.75, 0.25, 1.0, 0.0, 1.0, 0.0]) {
            assert!((found - expected).abs() <= 1e-7, "found {found}, expected {expected}");
        }
    }
}
