//! Generalized Gaussian distributions, fitted by their moments.
//!
//! The density of shape `a` falls off as `exp(−|x/b|^a)`: 1 is Laplace's, 2 is Gauss's. The
//! asymmetric one has a width `b` of its own on either side of 0 (Lasmar, Stitou and Berthoumieu,
//! "Multiscale skewed heavy tailed model for texture analysis", 2009).

use std::f64::consts::TAU;

/// The range of shapes to fit.
const SHAPES: (f64, f64) = (0.2, 10.0);
/// Bisections of that range.
const STEPS: usize = 50;

/// Fits the symmetric distribution; returns shape and variance. The shape is the one whose `(E|x|)²
/// / E x²` equals that of the values.
///
/// For zeros alone, the variance is 0 and the shape is the largest.
pub(super) fn symmetric(values: &[f64]) -> [f64; 2] {
    let moments = Moments::of(values);
    let shape = if moments.square > 0.0 { shape(moments.ratio()) } else { SHAPES.1 };
    [shape, moments.square]
}

/// Fits the asymmetric distribution; returns shape, mean, left and right variance.
///
/// With `g` the quotient of the two deviations, the shape is the one whose `(E|x|)² / E x²` equals
/// that of the values times `(g³ + 1)(g + 1) / (g² + 1)²`. The mean is `(b_right − b_left) Γ(2/a) /
/// Γ(1/a)`, where `b` is the deviation times `√(Γ(1/a) / Γ(3/a))`. For zeros alone, the shape is
/// the largest and the rest is 0.
pub(super) fn asymmetric(values: &[f64]) -> [f64; 4] {
    let Moments { left, right, .. } = Moments::of(values);
    if left.max(right) == 0.0 {
        return [SHAPES.1, 0.0, 0.0, 0.0];
    }
    let skew = (left.min(right) / left.max(right)).sqrt();
    let correction = (skew.powi(3) + 1.0) * (skew + 1.0) / (skew.powi(2) + 1.0).powi(2);
    let shape = shape(Moments::of(values).ratio() * correction);
    let [one, two, three] = ln_gammas(shape);
    let mean = (right.sqrt() - left.sqrt()) * (two - f64::midpoint(one, three)).exp();
    [shape, mean, left, right]
}

/// Means of magnitudes and squares over all values, and of squares over the negative and over the
/// positive ones.
struct Moments {
    magnitude: f64,
    square: f64,
    left: f64,
    right: f64,
}

impl Moments {
    fn of(values: &[f64]) -> Self {
        let mean_square = |belongs: fn(f64) -> bool| {
            let chosen = values.iter().filter(|v| belongs(**v));
            let (sum, count) =
                chosen.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
            if count > 0.0 { sum / count } else { 0.0 }
        };
        Self {
            magnitude: values.iter().map(|v| v.abs()).sum::<f64>() / values.len() as f64,
            square: mean_square(|_| true),
            left: mean_square(|v| v < 0.0),
            right: mean_square(|v| v > 0.0),
        }
    }

    fn ratio(&self) -> f64 {
        self.magnitude.powi(2) / self.square
    }
}

/// Finds by bisection the shape `a` with `(E|x|)² / E x² = Γ(2/a)² / (Γ(1/a) Γ(3/a))` equal to
/// `ratio`.
fn shape(ratio: f64) -> f64 {
    let (mut low, mut high) = SHAPES;
    for _ in 0..STEPS {
        let middle = f64::midpoint(low, high);
        let [one, two, three] = ln_gammas(middle);
        *(if (2.0 * two - one - three).exp() < ratio { &mut low } else { &mut high }) = middle;
    }
    f64::midpoint(low, high)
}

/// The logarithms of Γ at 1, 2 and 3 over the shape, which make up all moments.
fn ln_gammas(shape: f64) -> [f64; 3] {
    [1.0, 2.0, 3.0].map(|n| ln_gamma(n / shape))
}

/// The logarithm of Γ at a positive number, to 14 digits.
///
/// Stirling's series needs a large argument, which ten steps of `Γ(z) = Γ(z + 1) / z` provide.
fn ln_gamma(z: f64) -> f64 {
    let product: f64 = (0..10).map(|i| z + f64::from(i)).product();
    let z = z + 10.0;
    let inverse_square = 1.0 / (z * z);
    let terms = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0];
    let series = terms.iter().rev().fold(0.0, |sum, term| sum * inverse_square + term) / z;
    (z - 0.5) * z.ln() - z + 0.5 * TAU.ln() + series - product.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn assert_near(found: f64, expected: f64) {
        let error = (found - expected).abs();
        assert!(error <= 1e-12 * expected.abs().max(1.0), "found {found}, not {expected}");
    }

    #[test]
    fn the_gamma_function_has_its_known_values() {
        for (z, expected) in [(1.0, 1.0), (5.0, 24.0), (0.5, PI.sqrt()), (15.0, 87_178_291_200.0)] {
            assert_near(ln_gamma(z), f64::ln(expected));
        }
        assert_near(ln_gamma(0.1), 2.252_712_651_734_206);
    }

    #[test]
    fn the_ratios_of_laplace_and_gauss_give_their_shapes() {
        assert_near(shape(0.5), 1.0);
        assert_near(shape(2.0 / PI), 2.0);
        assert_near(shape(0.0), SHAPES.0);
        assert_near(shape(0.75), SHAPES.1);
    }

    #[test]
    fn a_mirrored_distribution_has_its_sides_exchanged() {
        let values = [-3.0, -1.0, 0.0, 0.5, 2.0, 0.1];
        let [shape, mean, left, right] = asymmetric(&values);
        assert_eq!([left, right], [5.0, 4.26 / 3.0]);
        assert!(mean < 0.0);
        assert_eq!(asymmetric(&values.map(|v| -v)), [shape, -mean, right, left]);
    }

    #[test]
    fn equal_sides_have_the_symmetric_shape_and_no_mean() {
        let values = [-3.0, -1.0, 0.0, 1.0, 3.0];
        let [shape, variance] = symmetric(&values);
        assert_eq!(variance, 4.0);
        assert_eq!(asymmetric(&values), [shape, 0.0, 5.0, 5.0]);
    }

    #[test]
    fn zeros_and_one_sided_values_have_finite_fits() {
        assert_eq!(symmetric(&[0.0; 4]), [SHAPES.1, 0.0]);
        assert_eq!(asymmetric(&[0.0; 4]), [SHAPES.1, 0.0, 0.0, 0.0]);
        let [shape, mean, left, right] = asymmetric(&[0.0, 1.0, 3.0]);
        assert!(shape.is_finite() && mean > 0.0);
        assert_eq!([left, right], [0.0, 5.0]);
    }
}
