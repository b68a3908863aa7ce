//! A frame prepared for comparison with others.

use rayon::prelude::*;
use wgdenoise::Image;

use crate::sample::Four;

/// A denoised frame and the features that tell its surfaces apart, all averaged over 3×3 pixels
/// because features are noisy.
#[derive(Clone, Debug)]
pub struct Shot {
    size: (u32, u32),
    /// Light, albedo and normal of each pixel, row by row; 0 for what is missing.
    pixels: Vec<[f32; 9]>,
    has_albedo: bool,
    has_normal: bool,
    light: f32,
}

/// What pixels are compared by.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Feature {
    Light,
    Albedo,
    Normal,
}

impl Shot {
    /// Takes linear light, linear albedo in [0, 1] and normals in [−1, 1]. Albedo and normals are
    /// clamped to these ranges: renderers store a lamp's light as its albedo, which would outweigh
    /// all surfaces.
    ///
    /// # Panics
    /// If the sizes differ.
    #[must_use]
    pub fn new(color: &Image, albedo: Option<&Image>, normal: Option<&Image>) -> Self {
        let images = [Some(color), albedo, normal];
        assert!(images.into_iter().flatten().all(|image| image.size() == color.size()), "sizes");
        Self {
            size: color.size(),
            pixels: smoothed(color.size(), images),
            has_albedo: albedo.is_some(),
            has_normal: normal.is_some(),
            light: mean_of(color),
        }
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The mean light, in which values that are not finite count as 0.
    pub(crate) fn light(&self) -> f32 {
        self.light
    }

    pub(crate) fn has(&self, feature: Feature) -> bool {
        match feature {
            Feature::Light => true,
            Feature::Albedo => self.has_albedo,
            Feature::Normal => self.has_normal,
        }
    }

    /// Pairs pixel `i` with the bilinear mean of `other` around another place.
    pub(crate) fn compare(&self, i: usize, other: &Self, four: &Four) -> Compared {
        Compared { own: self.pixels[i], other: four.mean(&other.pixels) }
    }
}

/// Two pixels to compare.
pub(crate) struct Compared {
    own: [f32; 9],
    other: [f32; 9],
}

impl Compared {
    /// The mean absolute difference of the channels.
    pub(crate) fn difference(&self, feature: Feature) -> f32 {
        let [own, other] = self.of(feature);
        own.iter().zip(other).map(|(a, b)| (a - b).abs()).sum::<f32>() / 3.0
    }

    /// The difference of light relative to the mean of both plus `dark`.
    pub(crate) fn light_difference(&self, dark: f32) -> f32 {
        self.difference(Feature::Light) / (self.mean_light() + dark)
    }

    /// The same, but signed; opposite changes of channels cancel.
    pub(crate) fn light_change(&self, dark: f32) -> f32 {
        let [own, other] = self.of(Feature::Light);
        let change = own.iter().zip(other).map(|(a, b)| a - b).sum::<f32>() / 3.0;
        change / (self.mean_light() + dark)
    }

    fn mean_light(&self) -> f32 {
        let [own, other] = self.of(Feature::Light);
        own.iter().chain(other).map(|v| v.max(0.0)).sum::<f32>() / 6.0
    }

    fn of(&self, feature: Feature) -> [&[f32]; 2] {
        let channels = feature as usize * 3..feature as usize * 3 + 3;
        [&self.own[channels.clone()], &self.other[channels]]
    }
}

fn mean_of(image: &Image) -> f32 {
    let finite = |v: &f32| if v.is_finite() { f64::from(*v) } else { 0.0 };
    let sum: f64 = image.pixels().par_iter().flatten_iter().map(finite).sum();
    sum as f32 / (3 * image.pixels().len()) as f32
}

/// The ranges of light, albedo and normal.
const RANGES: [[f32; 2]; 3] = [[f32::NEG_INFINITY, f32::INFINITY], [0.0, 1.0], [-1.0, 1.0]];

/// Means over 3×3 pixels, with edges repeated.
fn smoothed((width, height): (u32, u32), images: [Option<&Image>; 3]) -> Vec<[f32; 9]> {
    let (width, last) = (width as usize, height as usize - 1);
    let mut result = vec![[0.0; 9]; width * (last + 1)];
    result.par_chunks_mut(width).enumerate().for_each_init(
        || vec![[0.0; 3]; width],
        |columns, (y, row)| {
            let rows = [y.saturating_sub(1), y, (y + 1).min(last)];
            for (index, (image, range)) in images.iter().zip(RANGES).enumerate() {
                let Some(image) = image else { continue };
                add_up(rows.map(|y| &image.pixels()[y * width..][..width]), range, columns);
                for (x, pixel) in row.iter_mut().enumerate() {
                    let near = [x.saturating_sub(1), x, (x + 1).min(width - 1)];
                    let mean = sum(near.map(|x| columns[x])).map(|v| v / 9.0);
                    pixel[3 * index..][..3].copy_from_slice(&mean);
                }
            }
        },
    );
    result
}

/// Adds up three rows, one below the other, each value clamped to a range.
fn add_up(rows: [&[[f32; 3]]; 3], [least, most]: [f32; 2], columns: &mut [[f32; 3]]) {
    for (x, column) in columns.iter_mut().enumerate() {
        *column = sum(rows.map(|row| row[x].map(|v| v.clamp(least, most))));
    }
}

fn sum([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + b[i] + c[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_a_constant_and_spreads_a_pixel_over_nine() {
        let mut image = Image::filled(5, 4, [2.0; 3]).expect("a valid image");
        assert!(Shot::new(&image, None, None).pixels.iter().all(|pixel| pixel[..3] == [2.0; 3]));
        image.pixels_mut()[2 * 5 + 2] = [11.0; 3];
        let other = Image::filled(5, 4, [0.5; 3]).expect("a valid image");
        let found = Shot::new(&image, None, Some(&other));
        for (i, pixel) in found.pixels.iter().enumerate() {
            let is_near = (i % 5).abs_diff(2) <= 1 && (i / 5).abs_diff(2) <= 1;
            let light = if is_near { 3.0 } else { 2.0 };
            assert_eq!(*pixel, [light, light, light, 0.0, 0.0, 0.0, 0.5, 0.5, 0.5], "{i}");
        }
    }

    #[test]
    fn lamps_that_store_their_light_as_albedo_count_as_white() {
        let [black, lamp] = [0.0, 1e4].map(|v| Image::filled(4, 4, [v; 3]).expect("a valid image"));
        let mut wall = black.clone();
        wall.pixels_mut()[5] = [1e4; 3];
        let found = Shot::new(&lamp, Some(&wall), Some(&lamp));
        assert_eq!(
            found.pixels[5],
            [1e4, 1e4, 1e4, 1.0 / 9.0, 1.0 / 9.0, 1.0 / 9.0, 1.0, 1.0, 1.0]
        );
        let mut broken = black.clone();
        broken.pixels_mut()[5] = [f32::NAN; 3];
        assert!(Shot::new(&black, Some(&broken), None).pixels[5][3].is_nan());
    }

    #[test]
    fn edges_are_repeated() {
        let pixels = (0..6u8).map(|i| [f32::from(i), 0.0, f32::from(i / 3)]).collect();
        let image = Image::new(3, 2, pixels).expect("a valid image");
        let found = Shot::new(&image, None, None);
        // Columns 0, 0, 1 and rows 0, 0, 1: (0 + 0 + 1) / 3 + 3 / 3.
        assert!((found.pixels[0][0] - 4.0 / 3.0).abs() < 1e-6, "{:?}", found.pixels[0]);
        assert!((found.pixels[5][2] - 2.0 / 3.0).abs() < 1e-6, "{:?}", found.pixels[5]);
    }
}
