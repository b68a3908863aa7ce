//! The mean of what frames show of the same surfaces.

use rayon::prelude::*;
use wgdenoise::Image;

use crate::Offsets;
use crate::sharp::Patch;

/// An image of another frame, and how it counts for each pixel of the own one.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Of the own image's size.
    pub image: &'a Image,
    /// To the other frame.
    pub offsets: &'a Offsets,
    /// From 0 to 1, as [`agreement`](crate::agreement()) finds it.
    pub agreement: &'a [f32],
    /// From 0 to 1, as [`sharpness`](crate::sharpness()) finds it.
    pub sharpness: &'a [f32],
}

/// Each pixel of `own` averaged with those that the offsets lead to in the others; `own` counts 1,
/// the others as far as they agree.
///
/// # Panics
/// If the sizes differ.
#[must_use]
pub fn mean(own: &Image, others: &[Part<'_>]) -> Image {
    let pixels = own.pixels().len();
    for other in others {
        assert!([other.image.size(), other.offsets.size()] == [own.size(); 2], "sizes");
        assert!([other.agreement.len(), other.sharpness.len()] == [pixels; 2], "sizes");
    }
    let at = |(i, pixel): (usize, &[f32; 3])| {
        let (mut sum, mut weight) = (*pixel, 1.0);
        for other in others.iter().filter(|other| other.agreement[i] > 0.0) {
            let Some(patch) = Patch::around(other.offsets.end(i), own.size()) else { continue };
            let found = patch.mean(other.image.pixels(), other.sharpness[i]);
            weight += other.agreement[i];
            sum = std::array::from_fn(|c| sum[c] + other.agreement[i] * found[c]);
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

    fn part<'a>(image: &'a Image, offsets: &'a Offsets, agreement: &'a [f32]) -> Part<'a> {
        Part { image, offsets, agreement, sharpness: &[0.0; 6][..agreement.len()] }
    }

    #[test]
    fn others_count_as_far_as_they_agree() {
        let gray = |value| Image::filled(3, 1, [value; 3]).expect("a valid image");
        let still = Offsets::still(3, 1);
        let found = mean(
            &gray(1.0),
            &[
                part(&gray(4.0), &still, &[1.0, 0.5, 0.0]),
                part(&gray(7.0), &still, &[1.0, 0.0, 0.0]),
            ],
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
        let found = mean(&ramp(0.0), &[part(&ramp(-2.0), &offsets, &[1.0; 6])]);
        assert_eq!(found, ramp(0.0));
    }

    #[test]
    fn a_pixel_that_is_not_a_number_does_not_spread_to_where_it_counts_nothing() {
        let mut other = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        other.pixels_mut()[1] = [f32::NAN; 3];
        let own = Image::filled(3, 1, [1.0; 3]).expect("a valid image");
        let found = mean(&own, &[part(&other, &Offsets::still(3, 1), &[1.0, 0.0, 1.0])]);
        assert_eq!(found, own);
    }
}
