//! The color map for errors: perceptually uniform, from black through red to pale yellow.

/// Coefficients of `1, t, t², …` for red, green and blue.
///
/// Our least-squares fit to the 256 colors of magma, which Stéfan van der Walt and Nathaniel Smith
/// put into the public domain (CC0) with matplotlib. The maximum deviation is 6/255.
const COEFFICIENTS: [[f32; 7]; 3] = [
    [-0.0021, 0.2505, 8.3459, -27.667, 52.1707, -50.7586, 18.6643],
    [-0.0007, 0.6945, -3.596, 14.2539, -27.9446, 29.0539, -11.49],
    [-0.0095, 2.4953, 0.3291, -13.6466, 12.8811, 4.2699, -5.5708],
];

/// Maps an error in [0, 1] to screen values in [0, 1].
pub(crate) fn magma(error: f32) -> [f32; 3] {
    let t = error.clamp(0.0, 1.0);
    COEFFICIENTS.map(|terms| terms.iter().rev().fold(0.0, |sum, c| sum * t + c).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries 0, 64, 128, 192 and 255 of matplotlib's map.
    #[test]
    fn the_published_colors_are_met() {
        for (error, expected) in [
            (0.0, [0.001, 0.000, 0.014]),
            (64.0 / 255.0, [0.317, 0.072, 0.485]),
            (128.0 / 255.0, [0.716, 0.215, 0.475]),
            (192.0 / 255.0, [0.987, 0.536, 0.382]),
            (1.0, [0.987, 0.991, 0.750]),
        ] {
            for (found, expected) in magma(error).into_iter().zip(expected) {
                assert!((found - expected).abs() <= 6.0 / 255.0, "{found}, not {expected}");
            }
        }
    }

    #[test]
    fn larger_errors_are_lighter() {
        let luminance = |i: u16| {
            let [r, g, b] = magma(f32::from(i) / 255.0).map(|v| v.powf(2.2));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let steps: Vec<_> = (0..=255).step_by(15).map(luminance).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert_eq!(magma(f32::INFINITY), magma(1.0));
    }
}
