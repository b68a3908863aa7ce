//! Turns the tensor that the network outputs into an image.

use super::tensor::Tensor;
use super::transfer_function::decode;
use crate::image::Image;
use crate::model::Encoding;

/// Reverses the input encoding of color: [decodes](decode), divides by `input_scale` and keeps the
/// top left `width · height` pixels.
///
/// `tensor` is `[3, h, w]` in `[0, 1]`, at least as large as the image.
///
/// # Panics
/// Panics if the tensor does not have three channels or is smaller than the image, or a side is 0.
#[must_use]
pub fn output_process(tensor: &Tensor, input_scale: f32, width: u32, height: u32) -> Image {
    output_process_in(Encoding::default(), tensor, input_scale, width, height)
}

/// [`output_process`] for a network with another encoding.
///
/// # Panics
/// Panics like [`output_process`].
#[must_use]
pub fn output_process_in(
    encoding: Encoding,
    tensor: &Tensor,
    input_scale: f32,
    width: u32,
    height: u32,
) -> Image {
    assert_eq!(tensor.channels, 3, "channels of the network's output");
    let radiance = |v: f32| {
        let light = decode(encoding, f64::from(v)) / f64::from(input_scale);
        light.min(f64::from(f32::MAX)) as f32
    };
    let mut pixels = Vec::new();
    for y in 0..height as usize {
        for x in 0..width as usize {
            pixels.push([0, 1, 2].map(|c| radiance(tensor.at(c, y, x))));
        }
    }
    Image::new(width, height, pixels).expect("both sides are at least 1")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{input_process, pu_inverse};

    #[test]
    fn the_image_is_the_top_left_of_the_tensor() {
        let tensor = Tensor::from_fn(3, 4, 4, |c, y, x| (16 * c + 4 * y + x) as f32 / 48.0);
        let found = output_process(&tensor, 1.0, 3, 2);
        assert_eq!(found.size(), (3, 2));
        let expected = [6.0, 22.0, 38.0].map(|v| pu_inverse(f64::from(v / 48.0_f32)) as f32);
        assert_eq!(found.row(1)[2], expected);
    }

    #[test]
    fn radiance_is_divided_by_the_input_scale() {
        let tensor = Tensor::new(3, 1, 1, vec![0.0, 1.0, 1.0]);
        let [black, white, _] = output_process(&tensor, 2.0, 1, 1).pixels()[0];
        assert_eq!(black, 0.0);
        assert!((white / 32752.0 - 1.0).abs() < 1e-5, "found {white}");
    }

    #[test]
    fn it_undoes_the_input_process() {
        let pixels = (0..15u8).map(|i| [f32::from(i), 100.0 * f32::from(i), 0.001]).collect();
        let image = Image::new(5, 3, pixels).expect("a valid image");
        let found = output_process(&input_process(&image, None, None, 0.3, 4), 0.3, 5, 3);
        for (found, expected) in
            found.pixels().iter().flatten().zip(image.pixels().iter().flatten())
        {
            assert!(
                (found - expected).abs() <= 1e-5 * expected,
                "found {found}, expected {expected}"
            );
        }
    }
}
