//! The values of one pixel, in words.

use std::fmt::Write as _;

use wgdenoise::Image;

/// The value of an image at a pixel; `None` outside it.
pub(crate) fn value(image: &Image, [x, y]: [u32; 2]) -> Option<[f32; 3]> {
    (x < image.width() && y < image.height()).then(|| image.row(y)[x as usize])
}

/// One line with the pixel's place, its perceived error if that is shown, and its value in each image
/// that there is.
pub(crate) fn reading(
    at: [u32; 2],
    perceived: Option<f32>,
    images: &[(&str, Option<&Image>)],
    alpha: Option<f32>,
) -> String {
    let mut line = format!("{}, {}", at[0], at[1]);
    if let Some(error) = perceived {
        let _ = write!(line, "   FLIP {error:.3}");
    }
    for (name, image) in images {
        if let Some([r, g, b]) = image.and_then(|image| value(image, at)) {
            let _ = write!(line, "   {name} {} {} {}", number(r), number(g), number(b));
        }
    }
    if let Some(alpha) = alpha {
        let _ = write!(line, "   alpha {}", number(alpha));
    }
    line
}

/// Four digits, so that a line keeps its length while the cursor moves.
fn number(v: f32) -> String {
    match v.abs() {
        _ if !v.is_finite() => v.to_string(),
        0.0 => "0.0000".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{v:.2e}"),
        size if size >= 1000.0 => format!("{v:.0}"),
        size if size >= 10.0 => format!("{v:.2}"),
        _ => format!("{v:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_names_every_image_that_there_is() {
        let noisy = Image::filled(2, 2, [0.25, 12.5, 1e-7]).unwrap();
        let images = [("noisy", Some(&noisy)), ("albedo", None)];
        let line = reading([1, 0], None, &images, Some(0.5));
        assert_eq!(line, "1, 0   noisy 0.2500 12.50 1.00e-7   alpha 0.5000");
        assert_eq!(reading([2, 0], Some(0.25), &images, None), "2, 0   FLIP 0.250");
    }

    #[test]
    fn numbers_of_any_size_stay_short() {
        let values = [0.0, -1.5, 4321.4, 1e9, f32::NAN, f32::INFINITY];
        let shown = values.map(number);
        assert_eq!(shown, ["0.0000", "-1.5000", "4321", "1.00e9", "NaN", "inf"]);
    }
}
