//! Averages the same surfaces across frames.

use rayon::prelude::*;
use wgdenoise::Image;

use crate::Offsets;
use crate::sharp::{Patch, Reading};

/// Another frame's images, and their weights at each pixel of the frame to average.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// As many images as the frame to average has, of the same size.
    pub images: Vec<&'a Image>,
    /// Offsets from the frame to average to this one.
    pub offsets: &'a Offsets,
    /// Weight of each pixel from 0 to 1, as [`agreement`](crate::agreement()) finds it.
    pub agreement: &'a [f32],
}

/// Averages each pixel of a frame's images with the pixels its offsets lead to in the other frames.
/// `own` has weight 1, the others their agreement.
///
/// Between pixels, the others are sampled with Catmull-Rom splines, kept within the range of the
/// four nearest pixels. All images use the same sharpness, that of the most limited, so that images
/// that add up still do.
///
/// # Panics
/// If there is no image, or if numbers or sizes differ.
#[must_use]
pub fn mean(own: &[&Image], others: &[Part<'_>]) -> Vec<Image> {
    let size = own[0].size();
    for other in others {
        let sizes = other.images.iter().chain(own).map(|image| image.size());
        assert!(sizes.chain([other.offsets.size()]).all(|other| other == size), "sizes");
        assert_eq!(other.images.len(), own.len(), "images");
        assert_eq!(other.agreement.len(), own[0].pixels().len(), "sizes");
    }
    let mut result: Vec<_> = own.iter().map(|image| image.pixels().to_vec()).collect();
    average_rows(size, &mut result, others);
    let image = |pixels| Image::new(size.0, size.1, pixels).expect("the size is that of an image");
    result.into_iter().map(image).collect()
}

fn average_rows(size: (u32, u32), images: &mut [Vec<[f32; 3]>], others: &[Part<'_>]) {
    let width = size.0 as usize;
    let mut rows: Vec<Vec<_>> = (0..size.1).map(|_| Vec::new()).collect();
    for image in images {
        for (row, pixels) in rows.iter_mut().zip(image.chunks_mut(width)) {
            row.push(pixels);
        }
    }
    rows.par_iter_mut().enumerate().for_each_init(Vec::new, |readings, (y, row)| {
        for x in 0..width {
            let weight = add_others(y * width + x, others, readings, |image, light| {
                row[image][x] = std::array::from_fn(|c| row[image][x][c] + light[c]);
            });
            for image in row.iter_mut() {
                image[x] = image[x].map(|v| v / weight);
            }
        }
    });
}

/// Passes what the other frames add to each image at pixel `i` to `add`; returns the sum of all
/// weights.
fn add_others(
    i: usize,
    others: &[Part<'_>],
    readings: &mut Vec<Reading>,
    mut add: impl FnMut(usize, [f32; 3]),
) -> f32 {
    let mut weight = 1.0;
    for other in others.iter().filter(|other| other.agreement[i] > 0.0) {
        let Some(patch) = Patch::around(other.offsets.end(i), other.offsets.size()) else {
            continue;
        };
        readings.clear();
        readings.extend(other.images.iter().map(|image| patch.read(image.pixels())));
        let sharpness = readings.iter().map(|reading| reading.sharpness).fold(1.0, f32::min);
        for (image, reading) in readings.iter().enumerate() {
            add(image, reading.sharpened(sharpness).map(|v| v * other.agreement[i]));
        }
        weight += other.agreement[i];
    }
    weight
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part<'a>(image: &'a Image, offsets: &'a Offsets, agreement: &'a [f32]) -> Part<'a> {
        Part { images: vec![image], offsets, agreement }
    }

    #[test]
    fn others_count_as_far_as_they_agree() {
        let gray = |value| Image::filled(3, 1, [value; 3]).expect("a valid image");
        let still = Offsets::still(3, 1);
        let found = mean(
            &[&gray(1.0)],
            &[
                part(&gray(4.0), &still, &[1.0, 0.5, 0.0]),
                part(&gray(7.0), &still, &[1.0, 0.0, 0.0]),
            ],
        );
        assert_eq!(found[0].pixels(), [[4.0; 3], [2.0; 3], [1.0; 3]]);
    }

    #[test]
    fn light_is_fetched_from_where_the_surface_was() {
        let ramp = |from: f32| {
            let pixels = (0..6u8).map(|x| [from + f32::from(x); 3]).collect();
            Image::new(6, 1, pixels).expect("a valid image")
        };
        let offsets = Offsets::new(6, 1, vec![[2.0, 0.0]; 6]).expect("it fits");
        // What is at x here was at x + 2 there.
        let found = mean(&[&ramp(0.0)], &[part(&ramp(-2.0), &offsets, &[1.0; 6])]);
        assert_eq!(found, [ramp(0.0)]);
    }

    #[test]
    fn a_pixel_that_is_not_a_number_does_not_spread_to_where_it_counts_nothing() {
        let mut other = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        other.pixels_mut()[1] = [f32::NAN; 3];
        let own = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        let found = mean(&[&own], &[part(&other, &Offsets::still(3, 1), &[1.0, 0.0, 1.0])]);
        assert_eq!(found, [own]);
    }
}
