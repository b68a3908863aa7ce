//! A pixel's values as text.

use wgdenoise::Image;

/// The value of a pixel; `None` outside the image.
pub(crate) fn value(image: &Image, [x, y]: [u32; 2]) -> Option<[f32; 3]> {
    (x < image.width() && y < image.height()).then(|| image.row(y)[x as usize])
}

/// A pixel's position, its visible error if shown, and its value in each available image. Lines
/// break only between images, and numbers keep their place while the cursor moves.
pub(crate) fn reading(
    at: [u32; 2],
    perceived: Option<f32>,
    images: &[(&str, Option<&Image>)],
    alpha: Option<f32>,
) -> String {
    let place = format!("{:>5}, {:>5}", at[0], at[1]);
    let perceived = perceived.map(|error| format!("FLIP {error:.3}"));
    let values = images.iter().filter_map(|(name, image)| {
        let [r, g, b] = value((*image)?, at)?.map(number);
        Some(format!("{name} {r} {g} {b}"))
    });
    let alpha = alpha.map(|alpha| format!("alpha {}", number(alpha)));
    let groups = [place].into_iter().chain(perceived).chain(values).chain(alpha);
    groups.map(|group| group.replace(' ', NO_BREAK)).collect::<Vec<_>>().join("   ")
}

/// A non-breaking space.
const NO_BREAK: &str = "\u{a0}";

/// Formats four digits, in seven characters.
fn number(v: f32) -> String {
    let digits = match v.abs() {
        _ if !v.is_finite() => v.to_string(),
        0.0 => "0.0000".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{v:.2e}"),
        size if size >= 1000.0 => format!("{v:.0}"),
        size if size >= 10.0 => format!("{v:.2}"),
        _ => format!("{v:.4}"),
    };
    format!("{digits:>7}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_names_every_image_that_there_is() {
        let noisy = Image::filled(2, 2, [0.25, 12.5, 1e-7]).unwrap();
        let images = [("noisy", Some(&noisy)), ("albedo", None)];
        let found = |at, perceived, alpha| {
            let line = reading(at, perceived, &images, alpha);
            line.split("   ").map(|group| group.replace(NO_BREAK, " ")).collect::<Vec<_>>()
        };
        let expected = ["    1,     0", "noisy  0.2500   12.50 1.00e-7", "alpha  0.5000"];
        assert_eq!(found([1, 0], None, Some(0.5)), expected);
        assert_eq!(found([2, 0], Some(0.25), None), ["    2,     0", "FLIP 0.250"]);
    }

    #[test]
    fn numbers_of_any_size_stay_short() {
        let values = [0.0, -1.5, 4321.4, 1e9, f32::NAN, f32::INFINITY];
        let shown = values.map(|v| number(v).trim().to_string());
        assert_eq!(shown, ["0.0000", "-1.5000", "4321", "1.00e9", "NaN", "inf"]);
    }
}
