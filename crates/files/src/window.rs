//! Aligns images that cover different rectangles of the picture.

use ::exr::meta::attribute::IntegerBounds;
use ::exr::meta::header::Header;

use super::Problem;
use super::escape::escaped;
use wgdenoise::Image;

/// Where an image lies in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The rectangle that the image covers.
    pub(super) data: IntegerBounds,
    /// The rectangle that is shown.
    pub(super) display: IntegerBounds,
    /// Whether the file tells the two apart; PNG and JPEG hold what is shown, without a position.
    is_positioned: bool,
}

impl Place {
    /// The place of an EXR file's part.
    pub(super) fn of(header: &Header) -> Self {
        let display = header.shared_attributes.display_window;
        Self { data: header.data_window(), display, is_positioned: true }
    }

    /// A whole picture of this size.
    pub(super) fn sized((width, height): (u32, u32)) -> Self {
        let whole = IntegerBounds::from_dimensions((width as usize, height as usize));
        Self { data: whole, display: whole, is_positioned: false }
    }

    /// Whether the display window differs from what the image covers.
    pub(super) fn is_cropped(&self) -> bool {
        self.data != self.display
    }

    /// Says that an image was fitted to the display window.
    pub(super) fn cropping(&self) -> String {
        format!(
            "cropped and padded to the display window, {}; the pixels are {}",
            shown(self.display),
            shown(self.data)
        )
    }

    /// The rectangles of `self` and `other` that show the same: within one picture, all of both. An
    /// image without a position may show all of the display window.
    fn common(&self, other: &Self) -> Option<(IntegerBounds, IntegerBounds)> {
        let are_same = |a: IntegerBounds, b: IntegerBounds| a.size == b.size;
        if self.is_positioned && other.is_positioned && self.display == other.display {
            return Some((self.data, other.data));
        }
        let has_position = self.is_positioned && !other.is_positioned;
        if has_position && are_same(self.display, other.data) {
            return Some((self.data, self.display));
        }
        let has_position = other.is_positioned && !self.is_positioned;
        if has_position && are_same(self.data, other.display) {
            return Some((other.display, other.data));
        }
        are_same(self.data, other.data).then_some((other.data, other.data))
    }
}

/// Fits an image from a separate file to the color; returns a notice if it had to be moved.
///
/// Images of one picture, which has one display window, are aligned by their data windows; pixels
/// that are not covered become 0. Images without a position must have the size of the data or the
/// display window.
///
/// # Errors
/// If sizes differ and there is no common display window, or if they have no pixel in common.
pub(super) fn fit(
    image: Image,
    name: &str,
    from: &Place,
    color: &Place,
) -> Result<(Image, Option<String>), Problem> {
    let sizes = || other_size(image.size(), size(color.data));
    let (from, to) = from.common(color).ok_or_else(sizes)?;
    if from == to {
        return Ok((image, None));
    }
    if !overlap(from, to) {
        let [from, to] = [from, to].map(shown);
        return Err(Problem::Size(format!("covers {from} and the color {to}, which do not meet")));
    }
    Ok((align(image, from, to)?, Some(notice(name, from, to))))
}

fn size(window: IntegerBounds) -> (u32, u32) {
    (window.size.width() as u32, window.size.height() as u32)
}

fn overlap(a: IntegerBounds, b: IntegerBounds) -> bool {
    let meet = |a: i32, a_len: usize, b: i32, b_len: usize| {
        let distance = offset(b, a);
        distance < a_len as i64 && -distance < b_len as i64
    };
    meet(a.position.x(), a.size.width(), b.position.x(), b.size.width())
        && meet(a.position.y(), a.size.height(), b.position.y(), b.size.height())
}

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

/// Says that a layer was moved to another window.
pub(super) fn notice(layer: &str, from: IntegerBounds, to: IntegerBounds) -> String {
    format!(
        "`{}` covers {} and the color {}: it was cropped and padded with 0 to fit",
        escaped(layer),
        shown(from),
        shown(to)
    )
}

/// The error for two sizes that should be equal.
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

    fn placed(data: ((i32, i32), (usize, usize)), display: (i32, i32, usize, usize)) -> Place {
        let (x, y, width, height) = display;
        let display = IntegerBounds::new((x, y), (width, height));
        Place { data: IntegerBounds::new(data.0, data.1), display, is_positioned: true }
    }

    /// The top left pixel that the color gets from an image whose pixel at x, y holds
    /// x + 1 + 100 (y + 1); 0 if it is not covered. An error is a text.
    fn corner(from: Place, color: Place) -> Result<f32, String> {
        let (width, height) = size(from.data);
        let number = |i: u32| [(i % width + 1 + 100 * (i / width + 1)) as f32; 3];
        let pixels = (0..width * height).map(number).collect();
        let image = Image::new(width, height, pixels).unwrap();
        let (fitted, notice) = fit(image, "a.exr", &from, &color).map_err(|e| e.to_string())?;
        assert_eq!(fitted.size(), size(color.data));
        assert_eq!(notice.is_some(), from.data != color.data && fitted.pixels()[0][0] != 101.0);
        Ok(fitted.pixels()[0][0])
    }

    #[test]
    fn files_of_one_picture_are_aligned_by_their_windows() {
        let shown = (0, 0, 20, 20);
        let color = placed(((2, 3), (8, 8)), shown);
        assert_eq!(corner(color, color), Ok(101.0));
        assert_eq!(corner(placed(((1, 1), (8, 8)), shown), color), Ok(302.0), "shifted");
        assert_eq!(corner(placed(((4, 4), (8, 8)), shown), color), Ok(0.0), "not covered");
        let overscan = placed(((-2, -2), (24, 24)), shown);
        assert_eq!(corner(placed(((0, 0), (20, 20)), shown), overscan), Ok(0.0));
        assert_eq!(corner(overscan, placed(((0, 0), (20, 20)), shown)), Ok(303.0));
        let apart = corner(placed(((10, 3), (8, 8)), shown), color).unwrap_err();
        assert!(apart.starts_with("covers 8×8 pixels from (10, 3)"), "{apart}");
        assert!(apart.ends_with("which do not meet"), "{apart}");
        // Half the size is another picture, and not a crop of this one.
        let half = placed(((0, 0), (10, 10)), (0, 0, 10, 10));
        let error = corner(half, placed(((0, 0), (20, 20)), shown)).unwrap_err();
        assert!(error.contains("both must have the same size"), "{error}");
        // A file that has lost its windows, but is of the same size.
        assert_eq!(corner(placed(((0, 0), (8, 8)), (0, 0, 8, 8)), color), Ok(101.0));
    }

    #[test]
    fn images_without_a_position_show_the_display_window_or_all_pixels() {
        let overscan = placed(((-2, -2), (24, 24)), (0, 0, 20, 20));
        assert_eq!(corner(Place::sized((20, 20)), overscan), Ok(0.0));
        assert_eq!(corner(overscan, Place::sized((20, 20))), Ok(303.0));
        assert_eq!(corner(Place::sized((24, 24)), overscan), Ok(101.0));
        assert_eq!(corner(overscan, Place::sized((24, 24))), Ok(101.0));
        assert!(corner(Place::sized((20, 21)), overscan).is_err());
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
