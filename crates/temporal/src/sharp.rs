//! Images between their pixels, with less blur than a bilinear mean has.

use rayon::prelude::*;
use wgdenoise::Image;

use crate::Offsets;
use crate::sample::Four;

/// How much of the sharpening of Catmull-Rom splines each pixel takes at the end of its offset: from 0
/// for the bilinear mean to 1 for the spline.
///
/// Splines overshoot next to edges. Every image stays in the range of the four nearest pixels, and all
/// take the same share, so that images that add up still do. NaN is not sharpened.
///
/// # Panics
/// If the sizes differ.
#[must_use]
pub fn sharpness(images: &[&Image], offsets: &Offsets) -> Vec<f32> {
    assert!(images.iter().all(|image| image.size() == offsets.size()), "sizes");
    let at = |i: usize| {
        let Some(patch) = Patch::around(offsets.end(i), offsets.size()) else { return 0.0 };
        images.iter().map(|image| patch.sharpness(image.pixels())).fold(1.0, f32::min)
    };
    (0..offsets.pixels().len()).into_par_iter().map(at).collect()
}

/// The 4×4 pixels around a point, their edge repeated, and their weights by row and column.
pub(crate) struct Patch {
    four: Four,
    width: usize,
    columns: [usize; 4],
    rows: [usize; 4],
    across: [f32; 4],
    down: [f32; 4],
}

impl Patch {
    /// As [`Four::around`].
    pub(crate) fn around(point: [f32; 2], size: (u32, u32)) -> Option<Self> {
        let four = Four::around(point, size)?;
        let (width, height) = (size.0 as usize, size.1 as usize);
        let ((columns, across), (rows, down)) = (axis(point[0], width), axis(point[1], height));
        Some(Self { four, width, columns, rows, across, down })
    }

    /// The bilinear mean, sharpened.
    pub(crate) fn mean(&self, pixels: &[[f32; 3]], sharpness: f32) -> [f32; 3] {
        let bilinear = self.four.mean(pixels);
        if sharpness == 0.0 {
            return bilinear;
        }
        let spline = self.spline(pixels);
        std::array::from_fn(|c| bilinear[c] + sharpness * (spline[c] - bilinear[c]))
    }

    fn spline(&self, pixels: &[[f32; 3]]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (row, down) in self.rows.into_iter().zip(self.down) {
            for (column, across) in self.columns.into_iter().zip(self.across) {
                let pixel = pixels[row * self.width + column];
                sum = std::array::from_fn(|c| sum[c] + down * across * pixel[c]);
            }
        }
        sum
    }

    /// The largest share of the sharpening that stays in the range of the four nearest pixels.
    fn sharpness(&self, pixels: &[[f32; 3]]) -> f32 {
        let (bilinear, spline) = (self.four.mean(pixels), self.spline(pixels));
        let [least, most] = self.four.range(pixels);
        let share = |c: usize| {
            let change = spline[c] - bilinear[c];
            let room = (if change > 0.0 { most } else { least })[c] - bilinear[c];
            match change.abs() {
                size if size <= room.abs() => 1.0,
                size if size.is_finite() => room.abs() / size,
                _ => 0.0,
            }
        };
        (0..3).map(share).fold(1.0, f32::min)
    }
}

/// The four nearest centers along an axis, edges repeated, and their weights.
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

    fn image(values: &[f32]) -> Image {
        let pixels = values.iter().map(|v| [*v; 3]).collect();
        Image::new(values.len() as u32, 1, pixels).expect("a valid image")
    }

    /// An image at `x`, sharpened as far as it and another may be.
    fn along(values: &[f32], other: &[f32], x: f32) -> Option<f32> {
        let (image, other) = (image(values), image(other));
        let offsets = vec![[x, 0.0]; values.len()];
        let offsets = Offsets::new(values.len() as u32, 1, offsets).expect("it fits");
        let sharpness = sharpness(&[&image, &other], &offsets)[0];
        let patch = Patch::around([x, 0.0], image.size())?;
        Some(patch.mean(image.pixels(), sharpness)[0])
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
}
