//! Normals stored as colors.

use wgdenoise::Image;

/// Decodes an image of `n·0.5+0.5` to `n` if it is one; returns whether it was.
///
/// No normal is longer than 1, nor is a mean of normals, as at edges, in grass and in blur. So a
/// pixel longer than 1 is not a plain normal, and one that would be longer than 1 when decoded is
/// not an encoded one. If no component is negative, the majority of these pixels decides. If there
/// are hardly any, the image is encoded unless most pixels have length 1 as they are; means of
/// grass are shorter. If over one pixel in five is too long even when decoded, the image holds no
/// encoded normals. Background does not count.
pub(super) fn decode_if_encoded(image: &mut Image) -> bool {
    let pixels = || image.pixels().iter().filter(|p| !is_background(**p));
    let count = |holds: &dyn Fn([f32; 3]) -> bool| pixels().filter(|p| holds(**p)).count();
    let all = pixels().count();
    let meaningless = count(&|p| is_too_long(decoded(p)));
    if all == 0 || meaningless * 5 > all || pixels().flatten().any(|&v| v < 0.0) {
        return false;
    }
    let not_plain = count(&|p| is_too_long(p) && !is_too_long(decoded(p)));
    let not_encoded = count(&|p| is_too_long(decoded(p)) && !is_too_long(p));
    let is_encoded = if not_plain.max(not_encoded) * FEW > all {
        not_plain > not_encoded
    } else {
        count(&is_unit) * 2 <= all
    };
    if is_encoded {
        decode(image);
    }
    is_encoded
}

/// One pixel in this many may be anything.
const FEW: usize = 100;

/// Decodes every pixel; background becomes 0.
pub(super) fn decode(image: &mut Image) {
    for pixel in image.pixels_mut() {
        *pixel = if is_background(*pixel) { [0.0; 3] } else { decoded(*pixel) };
    }
}

/// Whether a pixel holds no normal: it is 0, an encoded 0 to 8 bits, or not finite.
fn is_background(pixel: [f32; 3]) -> bool {
    let near_half = |v: f32| (v - 0.5).abs() < 1.0 / 128.0;
    pixel == [0.0; 3] || pixel.iter().all(|&v| near_half(v)) || pixel.iter().any(|v| !v.is_finite())
}

fn decoded(pixel: [f32; 3]) -> [f32; 3] {
    pixel.map(|v| 2.0 * v - 1.0)
}

fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|v| v * v).sum::<f32>().sqrt()
}

/// Whether a vector is longer than a normal can be, rounding aside.
fn is_too_long(v: [f32; 3]) -> bool {
    length(v) > 1.05
}

fn is_unit(v: [f32; 3]) -> bool {
    (length(v) - 1.0).abs() < 0.02
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

    /// Vectors in random directions, the same each time.
    fn scattered(i: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| {
            let mixed = (i * 3 + c + 1).wrapping_mul(2_654_435_761) >> 8;
            (mixed % 2001) as f32 / 1000.0 - 1.0
        })
    }

    fn unit(v: [f32; 3]) -> [f32; 3] {
        let length = length(v).max(1e-6);
        v.map(|v| v / length)
    }

    fn add(a: [f32; 3], b: [f32; 3], amount: f32) -> [f32; 3] {
        [a[0] + amount * b[0], a[1] + amount * b[1], a[2] + amount * b[2]]
    }

    /// The mean of sixteen leaves around a direction.
    fn leaves(around: [f32; 3], i: usize) -> [f32; 3] {
        let leaf = |k: usize| unit(add(around, unit(scattered(16 * i + k)), 0.9));
        (0..16).fold([0.0; 3], |sum, k| add(sum, leaf(k), 1.0 / 16.0))
    }

    /// Checks that encoded normals are decoded and plain ones stay.
    fn check(what: &str, normals: &[[f32; 3]], stored: impl Fn([f32; 3]) -> [f32; 3]) {
        let image = |pixels: Vec<[f32; 3]>| Image::new(pixels.len() as u32, 1, pixels).unwrap();
        let plain = image(normals.to_vec());
        let mut encoded = image(normals.iter().map(|n| stored(n.map(|v| v * 0.5 + 0.5))).collect());
        assert!(decode_if_encoded(&mut encoded), "{what}: encoded");
        for (found, n) in
            encoded.pixels().iter().zip(normals).filter(|(found, _)| **found != [0.0; 3])
        {
            assert!(length(add(*found, *n, -1.0)) < 1e-5, "{what}: {found:?} {n:?}");
        }
        let mut untouched = plain.clone();
        assert!(!decode_if_encoded(&mut untouched) && untouched == plain, "{what}: plain");
    }

    /// In directions as in scenes: up, toward the camera on either side, and askew.
    #[test]
    fn short_normals_of_grass_and_leaves_are_noticed() {
        for around in [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.4, -0.5, 0.3]] {
            let grass: Vec<_> = (0..900).map(|i| leaves(around, i)).collect();
            let lengths = grass.iter().map(|n| length(*n)).sum::<f32>() / 900.0;
            assert!((0.5..0.9).contains(&lengths), "{lengths} is not short");
            check(&format!("grass {around:?}"), &grass, |n| n);
        }
    }

    #[test]
    fn backgrounds_of_0_and_one_half_do_not_hide_that_normals_are_encoded() {
        let sky =
            |i: usize| if i.is_multiple_of(4) { leaves([0.0, 1.0, 0.2], i) } else { [0.0; 3] };
        let scene: Vec<_> = (0..900).map(sky).collect();
        check("half", &scene, |n| n);
        check("black", &scene, |n| if n == [0.5; 3] { [0.0; 3] } else { n });
    }

    fn assert_stays(what: &str, normal: impl Fn(usize) -> [f32; 3]) {
        let mut image = Image::new(900, 1, (0..900).map(normal).collect()).unwrap();
        let before = image.clone();
        assert!(!decode_if_encoded(&mut image) && image == before, "{what}");
    }

    #[test]
    fn values_that_are_no_normals_at_all_stay() {
        assert_stays("noise", |i| scattered(i).map(|v| 2.0 * v + 2.0));
    }

    /// Plain normals without a negative component: flat walls, a floor, edges between them, and
    /// a ball of which only one octant is seen.
    #[test]
    fn plain_normals_that_are_not_negative_stay() {
        let floor_and_wall = |i: usize| {
            let share = if i.is_multiple_of(10) { (i % 7) as f32 / 7.0 } else { (i % 2) as f32 };
            [0.0, share, 1.0 - share]
        };
        let octant = |i: usize| unit(scattered(i).map(f32::abs));
        let short_octant = |i: usize| octant(i).map(|v| v * (0.5 + (i % 50) as f32 / 100.0));
        let askew = |_| unit([1.0; 3]);
        assert_stays("floor and wall", floor_and_wall);
        assert_stays("octant", octant);
        assert_stays("short octant", short_octant);
        assert_stays("one plane askew", askew);
    }
}
