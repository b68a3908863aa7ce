//! Denoises alpha as a further layer of the image.

use super::frame::{Denoised, Frame};
use crate::error::Result;
use crate::image::Image;

/// Alpha that is constant within this many pixels is settled: it has no noise.
const SETTLED: usize = 3;

/// Denoises a frame with its alpha, which `denoise` receives as the last layer.
pub(super) fn with_alpha(
    frame: &Frame<'_>,
    alpha: &[f32],
    denoise: impl FnOnce(&Frame<'_>) -> Result<Denoised>,
) -> Result<Denoised> {
    let gray = gray(alpha, frame.color.size())?;
    let layers: Vec<_> = frame.layers.iter().copied().chain([&gray]).collect();
    let mut found = denoise(&Frame { ends_in_alpha: true, ..frame.layers(&layers) })?;
    let found_alpha = found.layers.pop().expect("the alpha is a layer");
    found.alpha = Some(values(&found_alpha));
    let noisy: Vec<_> = [frame.color].into_iter().chain(frame.layers.iter().copied()).collect();
    settle(&mut found, &noisy, alpha, frame.panorama);
    Ok(found)
}

/// The alpha as an image of this size.
pub(super) fn gray(alpha: &[f32], (width, height): (u32, u32)) -> Result<Image> {
    Image::new(width, height, alpha.iter().map(|&a| [a; 3]).collect())
}

/// The alpha of a gray image.
pub(super) fn values(gray: &Image) -> Vec<f32> {
    gray.pixels().iter().map(|pixel| pixel[0]).collect()
}

/// Restores settled alpha, scales the color and layers that it premultiplies to match, and sets
/// empty places to black. `noisy` holds the noisy color and layers. If they are a panorama, they
/// `wrap` around at the left and right edge.
fn settle(found: &mut Denoised, noisy: &[&Image], alpha: &[f32], wrap: bool) {
    let width = noisy[0].width() as usize;
    let [least, most] = [f32::min, f32::max].map(|f| around(alpha, width, wrap, f));
    // `min` and `max` ignore NaN. Where all values around are NaN, the filled value stays.
    let is_settled = |i: usize| least[i].to_bits() == most[i].to_bits() && least[i].is_finite();
    let settled: Vec<_> = (0..alpha.len()).filter(|&i| is_settled(i)).collect();
    let found_alpha = found.alpha.as_mut().expect("the alpha was denoised");
    for (image, noisy) in [&mut found.color].into_iter().chain(&mut found.layers).zip(noisy) {
        let lights = lights_around(noisy, wrap);
        for &i in &settled {
            let pixel = &mut image.pixels_mut()[i];
            if least[i] == 0.0 && lights[i] == 0.0 {
                *pixel = [0.0; 3];
            } else if least[i] > 0.0 && found_alpha[i] > 0.0 {
                *pixel = pixel.map(|v| v / found_alpha[i] * least[i]);
            }
        }
    }
    for i in settled {
        found_alpha[i] = least[i];
    }
}

/// The largest magnitude of any channel around each pixel.
fn lights_around(image: &Image, wrap: bool) -> Vec<f32> {
    let brightness = |pixel: &[f32; 3]| pixel.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
    let lights: Vec<_> = image.pixels().iter().map(brightness).collect();
    around(&lights, image.width() as usize, wrap, f32::max)
}

/// Folds the values within [`SETTLED`] of each one, first along rows, which may `wrap` around, then
/// along columns.
fn around(values: &[f32], width: usize, wrap: bool, fold: fn(f32, f32) -> f32) -> Vec<f32> {
    let near = |at: usize, end: usize| at.saturating_sub(SETTLED)..(at + SETTLED + 1).min(end);
    let height = values.len() / width;
    let columns = |x: usize| {
        let turns = SETTLED * width;
        if wrap { near(x + turns, usize::MAX) } else { near(x, width) }
    };
    let along_row = |i: usize| {
        let (row, x) = (i / width * width, i % width);
        columns(x).map(|x| values[row + x % width]).reduce(fold).expect("it has itself")
    };
    let rows: Vec<_> = (0..values.len()).map(along_row).collect();
    let along_column =
        |i: usize| near(i / width, height).map(|y| rows[y * width + i % width]).reduce(fold);
    (0..values.len()).map(|i| along_column(i).expect("it has itself")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_seen_three_pixels_around_it_and_no_further() {
        let mut values = vec![0.0; 12 * 9];
        values[4 * 12 + 5] = 1.0;
        let found = around(&values, 12, false, f32::max);
        for (i, value) in found.into_iter().enumerate() {
            let is_near = (i % 12).abs_diff(5) <= 3 && (i / 12).abs_diff(4) <= 3;
            assert_eq!(value, f32::from(u8::from(is_near)), "{i}");
        }
    }

    #[test]
    fn a_panorama_is_seen_around_its_seam_however_narrow_it_is() {
        let ends = |width: usize, wrap| {
            let mut values = vec![0.0; width];
            values[0] = 1.0;
            around(&values, width, wrap, f32::max)
        };
        assert_eq!(ends(9, true), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!(ends(9, false), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(ends(2, true), [1.0; 2]);
    }

    #[test]
    fn alpha_that_is_not_a_number_takes_what_is_settled_around_it_or_stays_filled() {
        let color = Image::filled(20, 1, [0.5; 3]).expect("a valid image");
        let mut alpha = vec![1.0; 20];
        alpha[3] = f32::NAN;
        alpha[9..].fill(f32::NAN);
        let mut found =
            Denoised { color: color.clone(), layers: Vec::new(), alpha: Some(vec![0.5; 20]) };
        settle(&mut found, &[&color], &alpha, false);
        let expected = |i| if i < 12 { 1.0 } else { 0.5 };
        assert_eq!(found.alpha.unwrap(), (0..20).map(expected).collect::<Vec<_>>());
    }

    #[test]
    fn settled_alpha_comes_back_with_its_color_and_so_does_what_is_empty() {
        let mut color = Image::filled(20, 1, [0.0; 3]).expect("a valid image");
        let mut alpha = vec![0.0; 20];
        alpha[10..].fill(1.0);
        color.pixels_mut()[1] = [5.0; 3];
        let denoised = Image::filled(20, 1, [0.25; 3]).expect("a valid image");
        let mut found =
            Denoised { color: denoised, layers: Vec::new(), alpha: Some(vec![0.5; 20]) };
        settle(&mut found, &[&color], &alpha, false);
        let expected = |i| if (7..13).contains(&i) { 0.5 } else { alpha[i] };
        assert_eq!(found.alpha.unwrap(), (0..20).map(expected).collect::<Vec<_>>());
        let expected = |i| match i {
            5..7 => 0.0,
            13.. => 0.5,
            _ => 0.25,
        };
        for (i, pixel) in found.color.pixels().iter().enumerate() {
            assert_eq!(*pixel, [expected(i); 3], "{i}");
        }
    }

    #[test]
    fn layers_change_with_the_color_that_they_add_up_to() {
        let mut alpha = vec![0.0; 20];
        alpha[10..].fill(1.0);
        let gray = |v| Image::filled(20, 1, [v; 3]).expect("a valid image");
        let mut noisy = gray(0.0);
        noisy.pixels_mut()[2] = [5.0; 3];
        let layers = vec![gray(0.125), gray(0.125)];
        let mut found = Denoised { color: gray(0.25), layers, alpha: Some(vec![0.5; 20]) };
        settle(&mut found, &[&noisy, &noisy, &gray(0.0)], &alpha, false);
        let column = |image: &Image| image.pixels().iter().map(|p| p[0]).collect::<Vec<_>>();
        let expected = |i, own, empty: &[usize]| match i {
            13.. => 2.0 * own,
            _ if empty.contains(&i) => 0.0,
            _ => own,
        };
        let all: Vec<_> = (0..7).collect();
        for (image, own, empty) in [
            (&found.color, 0.25, &[6][..]),
            (&found.layers[0], 0.125, &[6]),
            (&found.layers[1], 0.125, &all),
        ] {
            assert_eq!(column(image), (0..20).map(|i| expected(i, own, empty)).collect::<Vec<_>>());
        }
    }
}
