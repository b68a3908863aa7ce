//! Normals stored as colors.

use wgdenoise::Image;

/// Decodes an image of `n·0.5+0.5` to `n`, if it is one, and returns whether it was.
///
/// It is one if no component is negative, nearly all pixels decode to unit vectors, and few are
/// unit vectors already. Background does not count.
pub(super) fn decode_if_encoded(image: &mut Image) -> bool {
    let lit = || image.pixels().iter().filter(|p| !is_background(**p));
    let (all, encoded) = (lit().count(), lit().filter(|p| is_unit(decoded(**p))).count());
    let plain = lit().filter(|p| is_unit(**p)).count();
    let unsigned = lit().flatten().all(|&v| v >= 0.0);
    if all == 0 || !unsigned || encoded * 10 < all * 8 || plain * 2 > all {
        return false;
    }
    decode(image);
    true
}

/// Decodes every pixel; background becomes 0.
pub(super) fn decode(image: &mut Image) {
    for pixel in image.pixels_mut() {
        *pixel = if is_background(*pixel) { [0.0; 3] } else { decoded(*pixel) };
    }
}

/// Whether a pixel is not a normal: 0, an encoded 0 to 8 bits, or not finite.
fn is_background(pixel: [f32; 3]) -> bool {
    let near_half = |v: f32| (v - 0.5).abs() < 1.0 / 128.0;
    pixel == [0.0; 3] || pixel.iter().all(|&v| near_half(v)) || pixel.iter().any(|v| !v.is_finite())
}

fn decoded(pixel: [f32; 3]) -> [f32; 3] {
    pixel.map(|v| 2.0 * v - 1.0)
}

fn is_unit(pixel: [f32; 3]) -> bool {
    let length = pixel.iter().map(|v| v * v).sum::<f32>().sqrt();
    (length - 1.0).abs() < 0.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(encode: fn(f32) -> f32) -> Image {
        let normals = [[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [-0.6, 0.0, 0.8], [0.0, -1.0, 0.0]];
        let mut pixels: Vec<_> = normals.iter().map(|n| n.map(encode)).collect();
        pixels.push([0.0; 3]);
        Image::new(5, 1, pixels).unwrap()
    }

    #[test]
    fn encoded_normals_are_decoded_and_others_left_alone() {
        let mut plain = image(|v| v);
        assert!(!decode_if_encoded(&mut plain) && plain == image(|v| v));
        let mut encoded = image(|v| v * 0.5 + 0.5);
        assert!(decode_if_encoded(&mut encoded));
        for (a, b) in encoded.pixels().iter().flatten().zip(plain.pixels().iter().flatten()) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn background_of_any_kind_becomes_0_and_does_not_hide_that_normals_are_encoded() {
        let mut encoded = image(|v| v * 0.5 + 0.5);
        let mut pixels = encoded.pixels().to_vec();
        pixels.extend([[0.5; 3], [128.0 / 255.0; 3], [127.0 / 255.0; 3], [f32::NAN, 0.5, 1.0]]);
        pixels.extend([[0.5, f32::NEG_INFINITY, 0.5]; 7]);
        encoded = Image::new(16, 1, pixels).unwrap();
        assert!(decode_if_encoded(&mut encoded));
        assert!(encoded.pixels()[4..].iter().all(|p| *p == [0.0; 3]), "{encoded:?}");
        assert_eq!(encoded.pixels()[0], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_wall_that_faces_the_axis_is_not_taken_for_encoded() {
        let mut wall = Image::filled(4, 4, [0.0, 0.0, 1.0]).unwrap();
        assert!(!decode_if_encoded(&mut wall));
    }
}
