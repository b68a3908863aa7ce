//! Maps light to screen colors. For display only: nothing here changes a result.

/// The tone curve from exposed light to screen values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curve {
    /// Clipped to [0, 1] and encoded as sRGB, as the command line writes PNG.
    Srgb,
    /// Highlights roll off: Krzysztof Narkowicz's fit of the ACES curve ("ACES Filmic Tone Mapping
    /// Curve", 2016), `x(2.51x + 0.03) / (x(2.43x + 0.59) + 0.14)`, then encoded as sRGB.
    Filmic,
}

impl Curve {
    pub(crate) const ALL: [(Self, &'static str); 2] =
        [(Self::Srgb, "sRGB"), (Self::Filmic, "Filmic")];
}

/// Exposure and curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tone {
    /// Exposure in stops.
    pub(crate) exposure: f32,
    pub(crate) curve: Curve,
}

impl Default for Tone {
    fn default() -> Self {
        Self { exposure: 0.0, curve: Curve::Srgb }
    }
}

impl Tone {
    /// Maximum exposure change in either direction, in stops.
    pub(crate) const STOPS: f32 = 16.0;

    /// The factor on light.
    pub(crate) fn gain(self) -> f32 {
        self.exposure.exp2()
    }

    /// Raises the exposure.
    pub(crate) fn brighten(&mut self, stops: f32) {
        self.exposure = (self.exposure + stops).clamp(-Self::STOPS, Self::STOPS);
    }

    pub(crate) fn next_curve(&mut self) {
        self.curve = match self.curve {
            Curve::Srgb => Curve::Filmic,
            Curve::Filmic => Curve::Srgb,
        };
    }

    /// Screen values in [0, 1]; the shader computes the same.
    pub(crate) fn screen(self, light: [f32; 3]) -> [f32; 3] {
        light.map(|v| {
            let exposed = v.max(0.0) * self.gain();
            srgb(match self.curve {
                Curve::Srgb => exposed,
                Curve::Filmic => filmic(exposed),
            })
        })
    }
}

fn filmic(x: f32) -> f32 {
    // Larger values would overflow, and the curve is flat well before.
    let x = x.min(1e4);
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The sRGB curve (IEC 61966-2-1) of light clipped to [0, 1].
pub(crate) fn srgb(light: f32) -> f32 {
    let v = light.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// The linear light of a screen value: the inverse of [`srgb`].
pub(crate) fn light_of(screen: f32) -> f32 {
    let v = screen.clamp(0.0, 1.0);
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f32, expected: f32) {
        assert!((found - expected).abs() < 1e-4, "found {found}, not {expected}");
    }

    #[test]
    fn a_stop_doubles_the_light() {
        let mut tone = Tone::default();
        tone.brighten(1.0);
        assert_eq!(tone.screen([0.09; 3]), Tone::default().screen([0.18; 3]));
        tone.brighten(100.0);
        assert_eq!(tone.exposure, Tone::STOPS);
    }

    #[test]
    fn srgb_has_its_published_values() {
        let screen = |v| Tone::default().screen([v; 3])[0];
        for (light, expected) in [(0.002, 0.025_84), (0.18, 0.461_356), (7.0, 1.0), (-1.0, 0.0)] {
            assert_near(screen(light), expected);
        }
    }

    /// Points computed from the published formula by hand.
    #[test]
    fn the_filmic_curve_rises_to_white_without_overflow() {
        for (x, expected) in [(0.0, 0.0), (0.5, 0.616_307), (1.0, 0.803_797)] {
            assert_near(filmic(x), expected);
        }
        let tone = Tone { curve: Curve::Filmic, ..Tone::default() };
        let shown = [0.01, 0.1, 1.0, 10.0, f32::MAX, f32::INFINITY].map(|v| tone.screen([v; 3])[0]);
        assert!(shown.is_sorted() && shown[5] > 0.999, "{shown:?}");
    }

    #[test]
    fn light_is_what_the_screen_was_given() {
        for screen in [0.0, 0.03, 0.2, 0.5, 1.0] {
            assert_near(srgb(light_of(screen)), screen);
        }
    }

    #[test]
    fn what_is_no_number_is_black() {
        assert_eq!(Tone::default().screen([f32::NAN; 3]), [0.0; 3]);
    }
}
