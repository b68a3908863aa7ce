//! Transfer curves, which decode stored values from 0 to 1 to light.

/// A curve between stored values and linear light, both from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Curve {
    /// sRGB (IEC 61966-2-1).
    Srgb,
    /// Light is the value raised to this power, as a PNG's gamma says.
    Power(f32),
    /// BT.709, BT.601 and BT.2020 (ITU-T H.273, transfer characteristics 1, 6, 14, 15).
    Bt709,
}

/// The constants of BT.2020, with which the curve's two pieces meet.
const BT709_SCALE: f32 = 1.099_296_8;
const BT709_TOE: f32 = 0.018_053_968;

impl Curve {
    /// Decodes a stored value to light.
    pub(crate) fn linear(self, v: f32) -> f32 {
        match self {
            Self::Srgb if v <= 0.04045 => v / 12.92,
            Self::Srgb => ((v + 0.055) / 1.055).powf(2.4),
            Self::Power(exponent) => v.powf(exponent),
            Self::Bt709 if v < 4.5 * BT709_TOE => v / 4.5,
            Self::Bt709 => ((v + BT709_SCALE - 1.0) / BT709_SCALE).powf(1.0 / 0.45),
        }
    }

    /// Encodes light clipped to [0, 1]: the inverse of [`linear`](Self::linear); NaN becomes 0.
    pub(crate) fn encoded(self, v: f32) -> f32 {
        let v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        match self {
            Self::Srgb if v <= 0.003_130_8 => 12.92 * v,
            Self::Srgb => 1.055 * v.powf(1.0 / 2.4) - 0.055,
            Self::Power(exponent) => v.powf(1.0 / exponent),
            Self::Bt709 if v < BT709_TOE => 4.5 * v,
            Self::Bt709 => BT709_SCALE * v.powf(0.45) - (BT709_SCALE - 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_display_can_show_is_clipped() {
        let shown =
            [f32::NAN, -1.0, 0.0, 1.0, 9e9].map(|v| (Curve::Srgb.encoded(v) * 255.0).round());
        assert_eq!(shown, [0.0, 0.0, 0.0, 255.0, 255.0]);
    }

    #[test]
    fn every_16_bit_value_survives_every_curve() {
        let powers = [0.2, 0.45455, 1.0, 1.8, 2.2, 5.0].map(Curve::Power);
        for curve in [Curve::Srgb, Curve::Bt709].into_iter().chain(powers) {
            for i in 0..=u16::MAX {
                let v = f32::from(i) / 65535.0;
                let again = (curve.encoded(curve.linear(v)) * 65535.0).round();
                assert_eq!(again, f32::from(i), "{curve:?}");
            }
        }
    }

    /// Values of the standards' formulas, computed in double precision.
    #[test]
    fn curves_are_those_of_the_standards() {
        for (curve, light) in [
            (Curve::Srgb, 0.214_041_14),
            (Curve::Power(2.2), 0.217_637_64),
            (Curve::Power(1.0), 0.5),
            (Curve::Bt709, 0.259_719_44),
        ] {
            assert!((curve.linear(0.5) - light).abs() < 1e-6, "{curve:?} {}", curve.linear(0.5));
        }
    }
}
