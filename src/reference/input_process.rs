//! Turns images into the tensor that the network reads.

use super::repair::{fill, repair_in};
use super::tensor::Tensor;
use super::transfer_function::encode;
use crate::image::Image;
use crate::model::{Encoding, TransferFunction};

/// Encodes the images for the network and extends them to multiples of `alignment` by repeating the
/// last column to the right and the last row downwards.
///
/// The result has three channels per given image, in the order color, albedo, normal, all in
/// `[0, 1]`. Color is [repaired](super::repair()), clamped to at least 0, multiplied by
/// `input_scale` and [encoded](encode) by [`pu`](super::pu). Albedo and normal are [filled](fill).
/// Albedo is clamped to `[0, 1]`. A normal is clamped to `[−1, 1]` and mapped to `[0, 1]`.
///
/// # Panics
/// Panics if the images differ in size or `alignment` is 0.
#[must_use]
pub fn input_process(
    color: &Image,
    albedo: Option<&Image>,
    normal: Option<&Image>,
    input_scale: f32,
    alignment: u32,
) -> Tensor {
    input_process_in(Encoding::default(), color, albedo, normal, input_scale, alignment)
}

/// [`input_process`] for a network trained with another encoding, in which light may exceed 1.
///
/// # Panics
/// Panics like [`input_process`].
#[must_use]
pub fn input_process_in(
    encoding: Encoding,
    color: &Image,
    albedo: Option<&Image>,
    normal: Option<&Image>,
    input_scale: f32,
    alignment: u32,
) -> Tensor {
    let encode_color = |v| encode_color(encoding, v, input_scale);
    let color = repair_in(encoding, color, input_scale).color;
    let (width, height) = color.size();
    let mut inputs: Vec<(Image, &dyn Fn(f32) -> f64)> = vec![(color, &encode_color)];
    inputs.extend(albedo.map(|image| (fill(image).color, &encode_albedo as _)));
    inputs.extend(normal.map(|image| (fill(image).color, &encode_normal as _)));
    let same_size = |(image, _): &(Image, _)| image.size() == (width, height);
    assert!(inputs.iter().all(same_size), "images differ in size");
    let aligned = |side: u32| side.next_multiple_of(alignment) as usize;
    Tensor::from_fn(3 * inputs.len(), aligned(height), aligned(width), |c, y, x| {
        let [right, below] = [x >= width as usize, y >= height as usize];
        if encoding.zero_padding && (right || below) {
            return 0.0;
        }
        let (x, y) = (x.min(width as usize - 1), y.min(height as usize - 1));
        let (image, encode) = &inputs[c / 3];
        encode(image.row(y as u32)[x][c % 3]) as f32
    })
}

/// Encodes a component of a repaired color.
pub(super) fn encode_color(encoding: Encoding, v: f32, input_scale: f32) -> f64 {
    let lowest = match encoding.transfer_function {
        TransferFunction::Signed => f32::MIN,
        _ => 0.0,
    };
    encode(encoding, f64::from(v.max(lowest)) * f64::from(input_scale))
}

fn encode_albedo(v: f32) -> f64 {
    f64::from(v).clamp(0.0, 1.0)
}

fn encode_normal(v: f32) -> f64 {
    f64::from(v).clamp(-1.0, 1.0) * 0.5 + 0.5
}

#[cfg(test)]
mod tests {
    use super::super::pu;
    use super::*;

    fn image(width: u32, height: u32, pixels: &[[f32; 3]]) -> Image {
        Image::new(width, height, pixels.to_vec()).expect("a valid image")
    }

    #[test]
    fn channels_stand_in_the_order_color_albedo_normal() {
        let color = image(1, 1, &[[0.0, 2.0, 1.0]]);
        let albedo = image(1, 1, &[[0.1, 0.2, 0.3]]);
        let normal = image(1, 1, &[[-1.0, 0.0, 0.5]]);
        let both = input_process(&color, Some(&albedo), Some(&normal), 1.0, 1).data;
        assert_eq!(both, [0.0, pu(2.0) as f32, pu(1.0) as f32, 0.1, 0.2, 0.3, 0.0, 0.5, 0.75]);
        assert_eq!(input_process(&color, None, Some(&normal), 1.0, 1).data[3..], both[6..]);
        assert_eq!(input_process(&color, None, None, 1.0, 1).data, both[..3]);
    }

    #[test]
    fn the_last_column_and_the_last_row_repeat_up_to_the_alignment() {
        let color = image(3, 1, &[[1.0; 3], [2.0; 3], [3.0; 3]]);
        let found = input_process(&color, None, None, 1.0, 2);
        let row = [1.0, 2.0, 3.0, 3.0].map(|v| pu(v) as f32);
        assert_eq!(found, Tensor::from_fn(3, 2, 4, |_, _, x| row[x]));
    }

    #[test]
    fn or_zeros_stand_there() {
        let color = image(3, 1, &[[1.0; 3], [2.0; 3], [3.0; 3]]);
        let zeros = Encoding { zero_padding: true, ..Encoding::default() };
        let found = input_process_in(zeros, &color, None, None, 1.0, 2);
        let row = [1.0, 2.0, 3.0, 0.0].map(|v| pu(v) as f32);
        assert_eq!(found, Tensor::from_fn(3, 2, 4, |_, y, x| if y == 0 { row[x] } else { 0.0 }));
    }

    #[test]
    fn aligned_sides_stay() {
        let color = image(4, 2, &[[1.0; 3]; 8]);
        assert_eq!(input_process(&color, None, None, 1.0, 2).shape(), (3, 2, 4));
    }

    #[test]
    fn color_is_scaled_and_then_limited() {
        let color = image(2, 1, &[[0.5, 10.0, 1e30]; 2]);
        let found = input_process(&color, None, None, 2.0, 1);
        let expected = [1.0, 20.0, 65504.0].map(|v| pu(v) as f32);
        assert_eq!(found, Tensor::from_fn(3, 1, 2, |c, _, _| expected[c]));
    }

    #[test]
    fn values_out_of_range_are_clamped_and_bad_pixels_filled() {
        let bad = image(3, 1, &[[f32::NAN; 3], [-f32::NAN; 3], [f32::NEG_INFINITY; 3]]);
        let found = input_process(&bad, Some(&bad), Some(&bad), 1.0, 1);
        assert_eq!(found, Tensor::from_fn(9, 1, 3, |c, _, _| if c < 6 { 0.0 } else { 0.5 }));
        let spot = image(3, 1, &[[0.25; 3], [f32::NAN; 3], [0.25; 3]]);
        let found = input_process(&spot, Some(&spot), Some(&spot), 1.0, 1);
        let even = [pu(0.25) as f32, 0.25, 0.625];
        assert_eq!(found, Tensor::from_fn(9, 1, 3, |c, _, _| even[c / 3]));
        let outside = image(2, 1, &[[-2.0; 3], [2.0; 3]]);
        let found = input_process(&outside, Some(&outside), Some(&outside), 1.0, 1);
        let limits = [[0.0, pu(2.0) as f32], [0.0, 1.0], [0.0, 1.0]];
        assert_eq!(found, Tensor::from_fn(9, 1, 2, |c, _, x| limits[c / 3][x]));
        let wide_gamut = image(1, 1, &[[-0.5, 2.0, -0.0]]);
        let found = input_process(&wide_gamut, None, None, 1.0, 1);
        assert_eq!(found.data, [0.0, pu(2.0) as f32, 0.0]);
    }
}
