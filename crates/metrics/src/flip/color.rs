//! The color spaces of FLIP, relative to the white of sRGB (D65).

use crate::Pixel;

/// Linear sRGB to CIE XYZ relative to white, with the reference implementation's digits.
const XYZ_OF_RGB: [Pixel; 3] = [
    of_white([10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0]),
    of_white([2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0]),
    of_white([1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0]),
];

const RGB_OF_XYZ: [Pixel; 3] = inverse(XYZ_OF_RGB);

/// Decodes sRGB values between 0 and 1 to linear light (IEC 61966-2-1).
pub(super) fn linear(encoded: [f32; 3]) -> Pixel {
    let light = |v: f32| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    encoded.map(|v| f64::from(light(v)))
}

/// Luminance and two opponents, red–green and blue–yellow, linear in light: `YCxCz`.
pub(super) fn opponents(rgb: Pixel) -> Pixel {
    let [x, y, z] = xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// `YCxCz` to linear sRGB, which may lie outside [0, 1].
pub(super) fn of_opponents([luminance, cx, cz]: Pixel) -> Pixel {
    let y = (luminance + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    RGB_OF_XYZ.map(|row| dot(row, xyz))
}

/// Linear sRGB to CIELAB, its chroma scaled by a hundredth of the lightness: colors look more
/// colorful in brighter light (Hunt).
pub(super) fn hunt_lab(rgb: Pixel) -> Pixel {
    let [x, y, z] = xyz(rgb).map(cube_root);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// The distance of two colors, small or large: city-block in lightness, Euclidean in chroma (Abasi
/// et al. 2020).
pub(super) fn hyab(a: Pixel, b: Pixel) -> f64 {
    let [lightness, x, y] = [0, 1, 2].map(|i| a[i] - b[i]);
    lightness.abs() + (x * x + y * y).sqrt()
}

/// CIELAB's cube root, linear near black.
fn cube_root(v: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    if v > DELTA.powi(3) { v.cbrt() } else { v / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

fn xyz(rgb: Pixel) -> Pixel {
    XYZ_OF_RGB.map(|row| dot(row, rgb))
}

/// Scales a row so that its product with white is 1.
const fn of_white([r, g, b]: Pixel) -> Pixel {
    let white = r + g + b;
    [r / white, g / white, b / white]
}

/// The inverse of the matrix with these rows, by Cramer's rule.
const fn inverse([a, b, c]: [Pixel; 3]) -> [Pixel; 3] {
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let whole = dot(a, bc);
    [
        [bc[0] / whole, ca[0] / whole, ab[0] / whole],
        [bc[1] / whole, ca[1] / whole, ab[1] / whole],
        [bc[2] / whole, ca[2] / whole, ab[2] / whole],
    ]
}

const fn cross(a: Pixel, b: Pixel) -> Pixel {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

const fn dot(a: Pixel, b: Pixel) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: Pixel, expected: Pixel, tolerance: f64) {
        for (f, e) in found.iter().zip(&expected) {
            assert!((f - e).abs() <= tolerance, "found {found:?}, not {expected:?}");
        }
    }

    #[test]
    fn opponents_of_gray_have_no_chroma_and_lead_back() {
        assert_near(opponents([1.0; 3]), [100.0, 0.0, 0.0], 1e-12);
        assert_near(opponents([0.0; 3]), [-16.0, 0.0, 0.0], 1e-12);
        for rgb in [[0.2, 0.7, 0.1], [1.0, 0.0, 0.5], [0.0, 0.0, 1.0]] {
            assert_near(of_opponents(opponents(rgb)), rgb, 1e-12);
        }
    }

    /// CIELAB of the sRGB primaries, to the digits of Lindbloom's calculator.
    #[test]
    fn lab_has_its_published_values() {
        let lab = |rgb| {
            let [lightness, a, b] = hunt_lab(rgb);
            [lightness, a / (0.01 * lightness), b / (0.01 * lightness)]
        };
        assert_near(lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.02);
        assert_near(lab([0.0, 1.0, 0.0]), [87.73, -86.18, 83.18], 0.02);
        assert_near(lab([0.0, 0.0, 1.0]), [32.30, 79.19, -107.86], 0.02);
        assert_near(hunt_lab([1.0; 3]), [100.0, 0.0, 0.0], 1e-9);
    }

    #[test]
    fn the_distance_adds_lightness_to_chroma() {
        assert_eq!(hyab([10.0, 3.0, 0.0], [7.0, 0.0, 4.0]), 3.0 + 5.0);
    }

    #[test]
    fn light_of_encoded_values_is_published() {
        assert_near(linear([0.0, 0.5, 1.0]), [0.0, 0.214_041, 1.0], 1e-6);
    }
}
