//! Folds a batch norm into the preceding convolution, in f64.

/// Statistics and affine parameters of a batch norm, one value per channel.
pub struct BatchNorm<'a> {
    /// Scale γ.
    pub weight: &'a [f32],
    /// Shift β.
    pub bias: &'a [f32],
    /// Mean over the training data.
    pub mean: &'a [f32],
    /// Variance over the training data.
    pub variance: &'a [f32],
    /// The epsilon added to the variance.
    pub eps: f64,
}

/// Folds `γ·(conv(x) + b − μ)/√(σ² + ε) + β` into one convolution: every weight of output channel
/// `o` is multiplied by `s = γ/√(σ² + ε)`, and the bias becomes `s·(b − μ) + β`. The output channel
/// is the slowest axis of `weight`.
pub fn fold(weight: &mut [f32], bias: &mut [f32], norm: &BatchNorm<'_>) {
    let per_channel = weight.len() / bias.len();
    for (o, filter) in weight.chunks_exact_mut(per_channel).enumerate() {
        let scale = f64::from(norm.weight[o]) / (f64::from(norm.variance[o]) + norm.eps).sqrt();
        for w in filter {
            *w = (f64::from(*w) * scale) as f32;
        }
        let centered = f64::from(bias[o]) - f64::from(norm.mean[o]);
        bias[o] = (scale * centered + f64::from(norm.bias[o])) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_equals_convolution_then_normalization() {
        let (mut weight, mut bias) = (vec![0.5, -2.0, 3.0, 0.25], vec![0.1, -0.3]);
        let norm = BatchNorm {
            weight: &[1.5, -0.5],
            bias: &[0.2, 0.7],
            mean: &[0.4, -1.0],
            variance: &[2.0, 0.09],
            eps: 1e-5,
        };
        let x = [0.7_f32, -1.3];
        let apply = |w: &[f32], b: f32| f64::from(w[0] * x[0] + w[1] * x[1] + b);
        let plain = [apply(&weight[..2], bias[0]), apply(&weight[2..], bias[1])];
        fold(&mut weight, &mut bias, &norm);
        for o in 0..2 {
            let scaled = f64::from(norm.weight[o]) * (plain[o] - f64::from(norm.mean[o]))
                / (f64::from(norm.variance[o]) + norm.eps).sqrt();
            let expected = scaled + f64::from(norm.bias[o]);
            let found = apply(&weight[o * 2..o * 2 + 2], bias[o]);
            // f32 rounding of three products and a sum, with values from 1 to 10.
            assert!((found - expected).abs() < 5e-6, "channel {o}: {found} ≠ {expected}");
        }
    }
}
