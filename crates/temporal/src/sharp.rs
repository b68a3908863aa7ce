//! Sampling between pixels with less blur than a bilinear mean.

use crate::sample::Four;

/// The 4×4 pixels around a point, with edges repeated, and their weights by row and column.
pub(crate) struct Patch {
    four: Four,
    width: usize,
    columns: [usize; 4],
    rows: [usize; 4],
    across: [f32; 4],
    down: [f32; 4],
}

impl Patch {
    /// Like [`Four::around`].
    pub(crate) fn around(point: [f32; 2], size: (u32, u32)) -> Option<Self> {
        let four = Four::around(point, size)?;
        let (width, height) = (size.0 as usize, size.1 as usize);
        let ((columns, across), (rows, down)) = (axis(point[0], width), axis(point[1], height));
        Some(Self { four, width, columns, rows, across, down })
    }

    /// Samples an image at the point.
    pub(crate) fn read(&self, pixels: &[[f32; 3]]) -> Reading {
        let rows = self.rows.map(|row| self.row(&pixels[row * self.width..][..self.width]));
        let near = [rows[1][1], rows[1][2], rows[2][1], rows[2][2]];
        let mean = self.four.mean_of(near);
        let spline = weighted(rows.map(|row| weighted(row, self.across)), self.down);
        let detail = std::array::from_fn(|c| spline[c] - mean[c]);
        Reading { mean, detail, sharpness: sharpness(mean, detail, range(near)) }
    }

    fn row(&self, row: &[[f32; 3]]) -> [[f32; 3]; 4] {
        let [first, .., last] = self.columns;
        // Inside the picture, one bounds check is enough.
        match row[first..=last].try_into() {
            Ok(four) => four,
            Err(_) => self.columns.map(|column| row[column]),
        }
    }
}

fn weighted([a, b, c, d]: [[f32; 3]; 4], weights: [f32; 4]) -> [f32; 3] {
    let [s, t, u, v] = weights;
    std::array::from_fn(|i| a[i] * s + b[i] * t + c[i] * u + d[i] * v)
}

/// Minimum and maximum per channel.
fn range([a, b, c, d]: [[f32; 3]; 4]) -> [[f32; 3]; 2] {
    let all = |pick: fn(f32, f32) -> f32| {
        std::array::from_fn(|i| pick(pick(a[i], b[i]), pick(c[i], d[i])))
    };
    [all(f32::min), all(f32::max)]
}

/// An image sampled between its pixels.
pub(crate) struct Reading {
    /// The bilinear mean.
    mean: [f32; 3],
    /// What Catmull-Rom splines add to it.
    detail: [f32; 3],
    /// The largest fraction of the detail that stays within the range of the four nearest pixels,
    /// since splines overshoot at edges. 0 if the detail is not finite; 1 if it is only rounding,
    /// so that a constant image, such as full alpha, does not soften the others.
    pub(crate) sharpness: f32,
}

impl Reading {
    /// The mean plus a fraction of the detail.
    pub(crate) fn sharpened(&self, sharpness: f32) -> [f32; 3] {
        if sharpness == 0.0 {
            return self.mean;
        }
        std::array::from_fn(|c| self.mean[c] + sharpness * self.detail[c])
    }
}

/// Bound on a spline's rounding error relative to the light: the magnitudes of its 16 weights add
/// up to at most 1.25², and weights, products and sums are rounded 26 times by 2⁻²⁴.
const ROUNDING: f32 = 3e-6;

fn sharpness(mean: [f32; 3], detail: [f32; 3], [least, most]: [[f32; 3]; 2]) -> f32 {
    let share = |c: usize| {
        let room = ((if detail[c] > 0.0 { most } else { least })[c] - mean[c]).abs();
        let rounding = ROUNDING * least[c].abs().max(most[c].abs());
        match detail[c].abs() {
            size if size <= room + rounding => 1.0,
            size if size.is_finite() => room / size,
            _ => 0.0,
        }
    };
    (0..3).map(share).fold(1.0, f32::min)
}

/// The four nearest centers along an axis, with edges repeated, and their weights.
fn axis(at: f32, side: usize) -> ([usize; 4], [f32; 4]) {
    let (first, t) = (at.floor(), at - at.floor());
    let index = |i: usize| ((first + i as f32 - 1.0).max(0.0) as usize).min(side - 1);
    let weights = [
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    ];
    (std::array::from_fn(index), weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgdenoise::Image;

    fn image(values: &[f32]) -> Image {
        let pixels = values.iter().map(|v| [*v; 3]).collect();
        Image::new(values.len() as u32, 1, pixels).expect("a valid image")
    }

    /// Samples an image at `x`, sharpened no more than it and another allow.
    fn along(values: &[f32], other: &[f32], x: f32) -> Option<f32> {
        let (image, other) = (image(values), image(other));
        let patch = Patch::around([x, 0.0], image.size())?;
        let [own, other] = [&image, &other].map(|image| patch.read(image.pixels()));
        Some(own.sharpened(own.sharpness.min(other.sharpness))[0])
    }

    fn at(values: &[f32], x: f32) -> Option<f32> {
        along(values, values, x)
    }

    #[test]
    fn pixels_and_ramps_stay_as_they_are() {
        let ramp = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        for (x, expected) in [(2.0, 2.0), (1.25, 1.25), (3.5, 3.5), (-0.5, 0.0)] {
            let found = at(&ramp, x).expect("it is inside");
            assert!((found - expected).abs() < 1e-6, "{x}: {found}");
        }
        assert_eq!(at(&ramp, 5.6), None);
    }

    #[test]
    fn a_peak_is_higher_than_its_bilinear_mean_and_an_edge_does_not_overshoot() {
        let found = at(&[0.0, 0.0, 1.0, 0.0, 0.0], 2.25).expect("it is inside");
        assert!((0.8..1.0).contains(&found), "{found}");
        assert_eq!(at(&[0.0, 0.0, 0.0, 1.0, 1.0], 1.5), Some(0.0));
        assert_eq!(at(&[0.0, 0.0, 1.0, 1.0, 1.0], 2.5), Some(1.0));
    }

    #[test]
    fn images_take_the_same_share() {
        let (peak, edge) = ([0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!(along(&peak, &edge, 2.25), Some(0.75));
        let sum = [0.0, 0.0, 2.0, 1.0, 1.0];
        assert_eq!(along(&sum, &edge, 2.25), Some(1.75));
    }

    #[test]
    fn a_pixel_that_is_not_a_number_does_not_reach_beyond_its_neighbors() {
        assert_eq!(at(&[f32::NAN, 1.0, 2.0, 3.0], 1.5), Some(1.5));
    }

    #[test]
    fn constant_light_leaves_the_detail_of_others() {
        for value in [1.0, 0.7, -3.3] {
            let constant = vec![[value; 3]; 6 * 6];
            for i in 0..1600_u16 {
                let point = [i % 40, i / 40].map(|k| 0.1277 * f32::from(k));
                let patch = Patch::around(point, (6, 6)).expect("it is inside");
                assert_eq!(patch.read(&constant).sharpness, 1.0, "{value} at {point:?}");
            }
        }
    }
}
