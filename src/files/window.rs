//! Parts of one file that cover different rectangles of the picture.

use ::exr::meta::attribute::IntegerBounds;

use super::Problem;
use crate::image::Image;

/// Brings an image of the window `from` into the window `to`; pixels outside `from` are 0.
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

/// What to say of a layer that was brought into another window.
pub(super) fn notice(layer: &str, from: IntegerBounds, to: IntegerBounds) -> String {
    format!(
        "`{layer}` covers {} and the colour {}: it was cropped and extended with 0 to fit",
        shown(from),
        shown(to)
    )
}

/// Two sizes that had to be the same.
pub(super) fn other_size(found: (u32, u32), expected: (u32, u32)) -> Problem {
    Problem::Size(format!(
        "is {}×{} pixels and the colour is {}×{}; both must be of one size",
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
}
