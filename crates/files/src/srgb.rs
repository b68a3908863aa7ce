//! The sRGB curve.

/// The inverse of [`encoded`] (IEC 61966-2-1).
pub(super) fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB curve, for values clipped to [0, 1]; NaN becomes 0.
pub(super) fn encoded(v: f32) -> f32 {
    let v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_display_can_show_is_clipped() {
        let shown = [f32::NAN, -1.0, 0.0, 1.0, 9e9].map(|v| (encoded(v) * 255.0).round());
        assert_eq!(shown, [0.0, 0.0, 0.0, 255.0, 255.0]);
    }
}
