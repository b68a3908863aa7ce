//! Parts of one file that cover different rectangles of the image.

use ::exr::meta::attribute::IntegerBounds;

use super::Problem;
use super::escape::escaped;
use wgdenoise::Image;

/// Moves an image from the window `from` to the window `to`; pixels outside `from` become 0.
pub(super) fn align(
    image: Image,
    from: IntegerBounds,
    to: IntegerBounds,
) -> Result<Image, Problem> {
    if from == to {
        return Ok(image);
    }
    let (width, height) = (to.size.width(), to.size.height());
    let mut pixels = vec![[0.0; 3]; width * height];
    let shift =
        (offset(to.position.x(), from.position.x()), offset(to.position.y(), from.position.y()));
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Some(source) = within(y as i64 + shift.1, image.height()) else { continue };
        let source = image.row(source);
        for (x, pixel) in row.iter_mut().enumerate() {
            if let Some(x) = within(x as i64 + shift.0, image.width()) {
                *pixel = source[x as usize];
            }
        }
    }
    Image::new(width as u32, height as u32, pixels).map_err(|e| Problem::Size(e.to_string()))
}

/// Tells that a layer was moved to another window.
pub(super) fn notice(layer: &str, from: IntegerBounds, to: IntegerBounds) -> String {
    format!(
        "`{}` covers {} and the color {}: it was cropped and padded with 0 to fit",
        escaped(layer),
        shown(from),
        shown(to)
    )
}

/// The problem with two sizes that had to be equal.
pub(super) fn other_size(found: (u32, u32), expected: (u32, u32)) -> Problem {
    Problem::Size(format!(
        "is {}×{} pixels and the color is {}×{}; both must have the same size",
        found.0, found.1, expected.0, expected.1
    ))
}

fn shown(window: IntegerBounds) -> String {
    let (size, corner) = (window.size, window.position);
    format!("{}×{} pixels from ({}, {})", size.width(), size.height(), corner.x(), corner.y())
}

fn offset(to: i32, from: i32) -> i64 {
    i64::from(to) - i64::from(from)
}

fn within(position: i64, length: u32) -> Option<u32> {
    u32::try_from(position).ok().filter(|&p| p < length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pixels_keep_their_place_in_the_picture_and_the_rest_is_0() {
        let image = Image::new(2, 2, vec![[1.0; 3], [2.0; 3], [3.0; 3], [4.0; 3]]).unwrap();
        let from = IntegerBounds::new((10, -5), (2, 2));
        let to = IntegerBounds::new((11, -6), (2, 3));
        let aligned = align(image.clone(), from, to).unwrap();
        let reds: Vec<f32> = aligned.pixels().iter().map(|p| p[0]).collect();
        assert_eq!((aligned.size(), reds), ((2, 3), vec![0.0, 0.0, 2.0, 0.0, 4.0, 0.0]));
        assert_eq!(align(image.clone(), from, from).unwrap(), image);
    }

    /// The pixel at a position of the whole picture.
    fn at(image: &Image, from: IntegerBounds, x: i64, y: i64) -> [f32; 3] {
        let corner = (i64::from(from.position.x()), i64::from(from.position.y()));
        match (u32::try_from(x - corner.0), u32::try_from(y - corner.1)) {
            (Ok(x), Ok(y)) if x < image.width() && y < image.height() => image.row(y)[x as usize],
            _ => [0.0; 3],
        }
    }

    proptest! {
        #[test]
        fn every_pixel_of_the_new_window_is_that_of_the_picture(
            size in (1_usize..9, 1_usize..9), to_size in (1_usize..9, 1_usize..9),
            corner in (any::<i32>(), any::<i32>()), near in (-9..9_i32, -9..9_i32),
            far in any::<bool>(),
        ) {
            let pixels = (0..size.0 * size.1).map(|i| [i as f32 + 1.0; 3]).collect();
            let image = Image::new(size.0 as u32, size.1 as u32, pixels).unwrap();
            let shift = |at: i32, by: i32| if far { by } else { at.saturating_add(by) };
            let from = IntegerBounds::new(corner, size);
            let to_corner = (shift(corner.0, near.0), shift(corner.1, near.1));
            let to = IntegerBounds::new(to_corner, to_size);
            let aligned = align(image.clone(), from, to).unwrap();
            prop_assert_eq!(aligned.size(), (to_size.0 as u32, to_size.1 as u32));
            for (y, x) in (0..to_size.1).flat_map(|y| (0..to_size.0).map(move |x| (y, x))) {
                let px = i64::from(to_corner.0) + x as i64;
                let py = i64::from(to_corner.1) + y as i64;
                prop_assert_eq!(aligned.row(y as u32)[x], at(&image, from, px, py));
            }
        }
    }
}
