//! The mean of what frames show of the same surfaces.

use rayon::prelude::*;
use wgdenoise::Image;

use crate::Offsets;

/// Each pixel of `own` averaged with those that the offsets lead to in the others; `own` counts 1,
/// the others as far as they agree.
///
/// # Panics
/// If the sizes differ.
#[must_use]
pub fn mean(own: &Image, others: &[(&Image, &Offsets, &[f32])]) -> Image {
    for (image, offsets, agreement) in others {
        assert!([image.size(), offsets.size()] == [own.size(); 2], "sizes");
        assert_eq!(agreement.len(), own.pixels().len(), "sizes");
    }
    let at = |(i, pixel): (usize, &[f32; 3])| {
        let (mut sum, mut weight) = (*pixel, 1.0);
        for (image, offsets, agreement) in others {
            let Some(four) = offsets.four(i).filter(|_| agreement[i] > 0.0) else { continue };
            weight += agreement[i];
            for (sum, value) in sum.iter_mut().zip(four.mean(image.pixels())) {
                *sum += value * agreement[i];
            }
        }
        sum.map(|v| v / weight)
    };
    let pixels = own.pixels().par_iter().enumerate().map(at).collect();
    let (width, height) = own.size();
    Image::new(width, height, pixels).expect("the size is that of an image")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_count_as_far_as_they_agree() {
        let gray = |value| Image::filled(3, 1, [value; 3]).expect("a valid image");
        let still = Offsets::still(3, 1);
        let found = mean(
            &gray(1.0),
            &[(&gray(4.0), &still, &[1.0, 0.5, 0.0]), (&gray(7.0), &still, &[1.0, 0.0, 0.0])],
        );
        assert_eq!(found.pixels(), [[4.0; 3], [2.0; 3], [1.0; 3]]);
    }

    #[test]
    fn light_is_fetched_from_where_the_surface_was() {
        let ramp = |from: f32| {
            let pixels = (0..6u8).map(|x| [from + f32::from(x); 3]).collect();
            Image::new(6, 1, pixels).expect("a valid image")
        };
        let offsets = Offsets::new(6, 1, vec![[2.0, 0.0]; 6]).expect("it fits");
        // What is at x here was at x + 2 there.
        let found = mean(&ramp(0.0), &[(&ramp(-2.0), &offsets, &[1.0; 6])]);
        assert_eq!(found, ramp(0.0));
    }

    #[test]
    fn a_pixel_that_is_not_a_number_does_not_spread_to_where_it_counts_nothing() {
        let mut other = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        other.pixels_mut()[1] = [f32::NAN; 3];
        let own = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        let found = mean(&own, &[(&other, &Offsets::still(3, 1), &[1.0, 0.0, 1.0])]);
        assert_eq!(found, own);
    }
}
