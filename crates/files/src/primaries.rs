//! Primaries: which colors red, green and blue are, and conversion between sets of them.

use ::exr::math::Vec2;
use ::exr::meta::attribute::Chromaticities;
use wgdenoise::Image;

type Matrix = [[f64; 3]; 3];

/// The primaries of sRGB and BT.709.
pub(super) const SRGB: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: D65,
};

const D65: Vec2<f32> = Vec2(0.3127, 0.329);

/// Bradford's chromatic adaptation, from XYZ to cone responses (Lam 1985; ICC.1, annex E).
const BRADFORD: Matrix =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The primaries with a number in ITU-T H.273 (table 2), as in a PNG's `cICP`.
pub(super) fn numbered(number: u8) -> Option<Chromaticities> {
    let of = |red, green, blue, white| Some(Chromaticities { red, green, blue, white });
    let dci_white = Vec2(0.314, 0.351);
    let p3 = [Vec2(0.68, 0.32), Vec2(0.265, 0.69), Vec2(0.15, 0.06)];
    match number {
        1 => Some(SRGB),
        4 => of(Vec2(0.67, 0.33), Vec2(0.21, 0.71), Vec2(0.14, 0.08), Vec2(0.31, 0.316)),
        5 => of(Vec2(0.64, 0.33), Vec2(0.29, 0.6), Vec2(0.15, 0.06), D65),
        6 | 7 => of(Vec2(0.63, 0.34), Vec2(0.31, 0.595), Vec2(0.155, 0.07), D65),
        9 => of(Vec2(0.708, 0.292), Vec2(0.17, 0.797), Vec2(0.131, 0.046), D65),
        11 => of(p3[0], p3[1], p3[2], dci_white),
        12 => of(p3[0], p3[1], p3[2], D65),
        22 => of(Vec2(0.63, 0.34), Vec2(0.295, 0.605), Vec2(0.155, 0.077), D65),
        _ => None,
    }
}

/// Whether two sets are the same up to rounding.
pub(super) fn are_alike(a: &Chromaticities, b: &Chromaticities) -> bool {
    let all = |c: &Chromaticities| [c.red, c.green, c.blue, c.white].map(|p| [p.x(), p.y()]);
    let (a, b) = (all(a), all(b));
    a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-3)
}

/// Converts linear color to sRGB's primaries; returns false and changes nothing if `from` is not a
/// color space.
pub(super) fn convert_to_srgb(image: &mut Image, from: &Chromaticities) -> bool {
    let Some(matrix) = to_srgb(from) else { return false };
    let matrix = matrix.map(|row| row.map(|v| v as f32));
    for pixel in image.pixels_mut() {
        let color = *pixel;
        *pixel = matrix.map(|row| row.iter().zip(color).map(|(m, v)| m * v).sum());
    }
    true
}

/// The matrix from the primaries `from` to XYZ, to sRGB's white, and to sRGB's primaries.
fn to_srgb(from: &Chromaticities) -> Option<Matrix> {
    let back = inverse(&to_xyz(&SRGB)?)?;
    let matrix = product(&product(&back, &adaptation(from.white, D65)?), &to_xyz(from)?);
    matrix.iter().flatten().all(|v| v.abs() < 1e3).then_some(matrix)
}

/// The matrix from linear RGB to XYZ: the columns are the primaries, scaled to add up to white
/// (SMPTE RP 177-1993).
fn to_xyz(primaries: &Chromaticities) -> Option<Matrix> {
    let [r, g, b] = [primaries.red, primaries.green, primaries.blue].map(xyz);
    let columns = [0, 1, 2].map(|i| [r[i], g[i], b[i]]);
    let scale = apply(&inverse(&columns)?, xyz(primaries.white));
    Some(columns.map(|row| [row[0] * scale[0], row[1] * scale[1], row[2] * scale[2]]))
}

/// The matrix that adapts XYZ from one white to another, by scaling cone responses.
fn adaptation(from: Vec2<f32>, to: Vec2<f32>) -> Option<Matrix> {
    let [from, to] = [from, to].map(|white| apply(&BRADFORD, xyz(white)));
    let scaled = [0, 1, 2].map(|i| BRADFORD[i].map(|v| v * to[i] / from[i]));
    Some(product(&inverse(&BRADFORD)?, &scaled))
}

/// XYZ of a chromaticity at a luminance of 1.
fn xyz(point: Vec2<f32>) -> [f64; 3] {
    let (x, y) = (f64::from(point.x()), f64::from(point.y()));
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn apply(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let column = |j: usize| apply(a, [b[0][j], b[1][j], b[2][j]]);
    let columns = [0, 1, 2].map(column);
    [0, 1, 2].map(|i| columns.map(|column| column[i]))
}

/// The inverse by cofactors; `None` for a singular matrix.
fn inverse(m: &Matrix) -> Option<Matrix> {
    let cofactor = |i: usize, j: usize| {
        let [(a, b), (c, d)] = [((i + 1) % 3, (i + 2) % 3), ((j + 1) % 3, (j + 2) % 3)];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    let is_usable = determinant.is_finite() && determinant.abs() > 1e-9;
    is_usable.then(|| [0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor(j, i) / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: &Matrix, expected: &Matrix, tolerance: f64) {
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < tolerance, "{found:?}");
        }
    }

    #[test]
    fn srgb_to_xyz_is_the_matrix_of_the_standard() {
        let iec = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        near(&to_xyz(&SRGB).unwrap(), &iec, 1e-4);
    }

    /// The published matrices: ITU-R BT.2407's for BT.2020, and ACES's for AP1, which adapts from
    /// its white of about 6000 K by Bradford's method.
    #[test]
    fn wide_primaries_become_srgb_as_published() {
        let bt2020 =
            [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        near(&to_srgb(&numbered(9).unwrap()).unwrap(), &bt2020, 1e-4);
        let ap1 = Chromaticities {
            red: Vec2(0.713, 0.293),
            green: Vec2(0.165, 0.83),
            blue: Vec2(0.128, 0.044),
            white: Vec2(0.32168, 0.33767),
        };
        let aces = [
            [1.70505, -0.62179, -0.08326],
            [-0.13026, 1.14080, -0.01055],
            [-0.02400, -0.12897, 1.15297],
        ];
        near(&to_srgb(&ap1).unwrap(), &aces, 2e-4);
    }

    #[test]
    fn every_numbered_white_stays_white() {
        let numbers = (0..=u8::MAX).filter_map(numbered);
        assert_eq!(numbers.clone().count(), 9);
        for primaries in numbers {
            let mut white = Image::filled(1, 1, [0.5; 3]).unwrap();
            assert!(convert_to_srgb(&mut white, &primaries));
            assert!(white.pixels()[0].iter().all(|v| (v - 0.5).abs() < 1e-5), "{white:?}");
        }
    }

    #[test]
    fn primaries_on_a_line_or_without_numbers_are_not_applied() {
        let flat = Chromaticities { blue: Vec2(0.47, 0.465), ..SRGB };
        let zero = Chromaticities { white: Vec2(0.3, 0.0), ..SRGB };
        let nan = Chromaticities { red: Vec2(f32::NAN, 0.3), ..SRGB };
        for broken in [flat, zero, nan] {
            let mut image = Image::filled(1, 1, [0.1, 0.2, 0.3]).unwrap();
            assert!(!convert_to_srgb(&mut image, &broken), "{broken:?}");
            assert_eq!(image.pixels(), [[0.1, 0.2, 0.3]]);
        }
    }
}
