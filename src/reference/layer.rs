//! Further layers of an image: see [`repair_layer`] and [`denoise_layer`].

use super::denoise::{Images, predicted};
use super::kernel_pyramid::kernel_pyramid;
use super::repair::{MOST, Repaired, is_finite, mean_around, repair_in, substituted};
use crate::image::Image;
use crate::model::{Encoding, Weights};

/// Repairs a layer where its image's `beauty` is repaired, so that layers that add up to the beauty
/// still do:
///
/// 1. +∞ stands for the same value as in the beauty.
/// 2. Where the beauty or the layer is missing, the layer is filled like the beauty.
/// 3. Elsewhere, each channel is multiplied by the factor by which the repair changes the beauty's.
///
/// A pixel counts where the beauty's does.
#[must_use]
pub fn repair_layer(
    encoding: Encoding,
    beauty: &Image,
    layer: &Image,
    input_scale: f32,
) -> Repaired {
    let Repaired { color: repaired, valid } = repair_in(encoding, beauty, input_scale);
    let mut color = layer.clone();
    for (i, value) in color.pixels_mut().iter_mut().enumerate() {
        let place = [i % beauty.width() as usize, i / beauty.width() as usize].map(|v| v as i64);
        let [before, own] = [beauty, layer].map(|image| substituted(image, beauty, place));
        let after = repaired.pixels()[i];
        *value = if is_finite(before) && is_finite(own) {
            [0, 1, 2].map(|c| own[c].clamp(-MOST, MOST) * factor(before[c], after[c]))
        } else {
            mean_around(layer, beauty, place)
        };
    }
    Repaired { color, valid }
}

fn factor(before: f32, after: f32) -> f32 {
    if before == 0.0 { 1.0 } else { after / before }
}

/// Filters a layer with the kernels that the network predicts for a frame, and demodulates it like
/// the color if it is `light`. The network must predict a kernel pyramid.
///
/// # Panics
/// Panics if the images differ in size.
#[must_use]
pub fn denoise_layer(
    weights: &Weights,
    images: Images<'_>,
    (layer, light): (&Image, bool),
    input_scale: f32,
) -> Image {
    let (logits, albedo) = predicted(weights, images, input_scale);
    let encoding = weights.metadata().encoding();
    let Repaired { color, valid } = repair_layer(encoding, images.color, layer, input_scale);
    kernel_pyramid(&logits, &color, &valid, albedo.as_ref().filter(|_| light))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f32]) -> Image {
        let pixels = values.iter().map(|&v| [v; 3]).collect();
        Image::new(values.len() as u32, 1, pixels).expect("a valid image")
    }

    fn repaired(beauty: &[f32], layer: &[f32]) -> Repaired {
        let encoding = Encoding { gathered: true, ..Encoding::default() };
        repair_layer(encoding, &row(beauty), &row(layer), 1.0)
    }

    #[test]
    fn a_layer_of_good_pixels_stays_and_so_does_what_is_below_0() {
        let layer = [0.1, -3.0, 0.0, 7.0];
        assert_eq!(repaired(&[1.0, 2.0, 0.0, 3.0], &layer).color, row(&layer));
    }

    #[test]
    fn a_pixel_missing_in_either_image_is_filled() {
        let nan = f32::NAN;
        let found = repaired(&[1.0, nan, 3.0, 1.0, 1.0], &[0.5, 9.0, 1.5, nan, 0.5]);
        // The mean of the first and the third, whose neighbor is bad too.
        assert_eq!(found.color, row(&[0.5, 1.0, 1.5, 1.0, 0.5]));
        let found = repaired(&[nan; 2], &[1.0, 2.0]);
        assert_eq!((found.color, found.valid), (row(&[2.0, 1.0]), vec![false; 2]));
    }

    #[test]
    fn a_firefly_is_darkened_in_every_layer_by_the_same_factor() {
        let found = repaired(&[1.0, 1e6, 1.0], &[0.5, 4e5, 0.5]).color;
        assert!((found.pixels()[1][0] / (0.4 * 256.0) - 1.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_sun_of_infinite_light_is_as_bright_as_in_the_beauty() {
        let inf = f32::INFINITY;
        let beauty = Image::filled(3, 3, [inf; 3]).expect("a valid image");
        let encoding = Encoding { gathered: true, ..Encoding::default() };
        let found = repair_layer(encoding, &beauty, &beauty, 1.0).color;
        assert_eq!(found.pixels(), [[65504.0; 3]; 9]);
    }
}
