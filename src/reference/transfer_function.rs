//! The curves from color to the network's values. The default is a perceptually uniform encoding,
//! [`pu`].
//!
//! Aydın, Mantiuk and Seidel, "Extending Quality Metrics to Full Luminance Range Images" (2008),
//! designed a curve on which equal steps look equally large at any luminance. [`pu`] is the closed
//! form that Intel Open Image Denoise fitted to it for denoising: a line in the darks, a power in
//! the middle, a logarithm in the lights.

use crate::model::{Encoding, TransferFunction};

/// The radiance, times the input scale, that the curves for light map to 1: the largest finite
/// 16-bit float.
pub const LARGEST: f64 = 65504.0;

const A: f64 = 1.412_837_65e3;
const B: f64 = 1.645_931_72;
const C: f64 = 0.431_384_981;
const D: f64 = -2.941_396_09e-3;
const E: f64 = 0.192_653_254;
const F: f64 = 6.260_260_94e-3;
const G: f64 = 0.998_620_152;
/// Where the line ends and the power begins, as radiance and as encoded value.
const Y0: f64 = 1.579_457_60e-6;
const X0: f64 = 2.231_517_11e-3;
/// Where the power ends and the logarithm begins, as radiance and as encoded value.
const Y1: f64 = 3.220_876_31e-2;
const X1: f64 = 0.370_974_749;

/// Encodes a radiance of at least 0: 0 maps to 0 and [`LARGEST`] to 1.
#[must_use]
pub fn pu(y: f64) -> f64 {
    curve(y) / curve(LARGEST)
}

/// The radiance that encodes to `x`, which must be at least 0.
#[must_use]
pub fn pu_inverse(x: f64) -> f64 {
    let x = x * curve(LARGEST);
    if x <= X0 {
        x / A
    } else if x <= X1 {
        ((x - D) / B).powf(1.0 / C)
    } else {
        ((x - G) / E).exp() - F
    }
}

/// Encodes an exposed color component: into `[0, 1]`, or beyond 1 for light above [`LARGEST`].
/// Only [`TransferFunction::Signed`] accepts negative values.
#[must_use]
pub fn encode(encoding: Encoding, exposed: f64) -> f64 {
    let light = exposed.min(f64::from(encoding.brightest()));
    match encoding.transfer_function {
        TransferFunction::Pu => pu(light),
        TransferFunction::Log => (light + 1.0).ln() / (LARGEST + 1.0).ln(),
        TransferFunction::Srgb => srgb(exposed.clamp(0.0, 1.0)),
        TransferFunction::Signed => exposed.clamp(-1.0, 1.0) * 0.5 + 0.5,
    }
}

/// The exposed component that [`encode`] maps to `encoded`. Values outside its range are clamped
/// first.
#[must_use]
pub fn decode(encoding: Encoding, encoded: f64) -> f64 {
    let x = encoded.clamp(0.0, encode(encoding, f64::INFINITY));
    match encoding.transfer_function {
        TransferFunction::Pu => pu_inverse(x),
        TransferFunction::Log => (x * (LARGEST + 1.0).ln()).exp() - 1.0,
        TransferFunction::Srgb if x <= 0.04045 => x / 12.92,
        TransferFunction::Srgb => ((x + 0.055) / 1.055).powf(2.4),
        TransferFunction::Signed => x * 2.0 - 1.0,
    }
}

fn srgb(y: f64) -> f64 {
    if y <= 0.003_130_8 { y * 12.92 } else { 1.055 * y.powf(1.0 / 2.4) - 0.055 }
}

/// The published curve, which reaches 3.135 at [`LARGEST`].
fn curve(y: f64) -> f64 {
    if y <= Y0 {
        A * y
    } else if y <= Y1 {
        B * y.powf(C) + D
    } else {
        E * (y + F).ln() + G
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_and_the_middle_are_where_the_publication_has_them() {
        assert_eq!(pu(0.0), 0.0);
        assert_eq!(pu(LARGEST), 1.0);
        // At a radiance of 1 the curve is G + E·ln(1 + F), and ln(1 + F) ≈ F − F²/2.
        let at_one = 0.998_620_152 + 0.192_653_254 * (6.260_260_94e-3 - 1.959_54e-5);
        assert!((curve(1.0) - at_one).abs() < 1e-7, "found {}", curve(1.0));
        assert!((curve(LARGEST) - 3.135).abs() < 1e-3, "found {}", curve(LARGEST));
    }

    #[test]
    fn every_curve_is_undone_and_spans_0_to_1() {
        for transfer_function in TransferFunction::ALL {
            let curve = Encoding { transfer_function, ..Encoding::default() };
            let least = if transfer_function == TransferFunction::Signed { -1.0 } else { 0.0 };
            let most = if transfer_function.is_hdr() { LARGEST } else { 1.0 };
            assert!(encode(curve, least).abs() < 1e-12 && (encode(curve, most) - 1.0).abs() < 1e-9);
            for value in [least, 1e-6, 1e-3, 0.18, 1.0, 100.0, most] {
                let value = value.min(most);
                let error = (decode(curve, encode(curve, value)) - value).abs();
                assert!(error <= 1e-5 * value.abs(), "{curve:?}: {value} is off by {error}");
            }
        }
    }

    #[test]
    fn light_of_any_size_comes_back_where_it_has_no_bound_and_is_cut_where_it_has() {
        for transfer_function in [TransferFunction::Pu, TransferFunction::Log] {
            let bounded = Encoding { transfer_function, ..Encoding::default() };
            let unbounded = Encoding { unbounded: true, ..bounded };
            for value in [1e6, 1e12, 1e29] {
                let error = decode(unbounded, encode(unbounded, value)) / value - 1.0;
                assert!(error.abs() < 1e-5, "{transfer_function:?}: {value} is off by {error}");
                assert_eq!(encode(bounded, value), encode(bounded, LARGEST));
                assert!(decode(bounded, encode(unbounded, value)) < LARGEST * 1.00001);
            }
        }
    }

    #[test]
    fn the_three_pieces_meet() {
        for (y, x) in [(Y0, X0), (Y1, X1)] {
            let (below, above) = (curve(y), curve(y * (1.0 + 1e-9)));
            assert!((below - above).abs() < 1e-6, "a jump from {below} to {above} at {y}");
            assert!((below - x).abs() < 1e-6, "{y} encodes to {below}, its inverse breaks at {x}");
        }
    }

    #[test]
    fn decoding_undoes_encoding_from_the_darkest_to_the_brightest() {
        for exponent in -90..=16 {
            let y = 1.7 * f64::from(exponent).exp2();
            let y = y.min(LARGEST);
            let error = (pu_inverse(pu(y)) / y - 1.0).abs();
            assert!(error < 1e-5, "{y} comes back off by {error}");
        }
    }
}
