//! How close an image is to its reference, in the metrics that denoising papers report, and how
//! good it looks without one.

use wgdenoise::{Error, Image, Result};

mod brisque;
mod flip;
mod ssim;
mod window;

pub use brisque::brisque;
pub use flip::{Flip, PIXELS_PER_DEGREE, flip};

/// Metrics of one image against its reference. Smaller is better, except for `psnr` and `ssim`.
///
/// Both images are first multiplied by the factor that brings the *reference's* log-average
/// luminance to 0.18. L1, PSNR and SSIM then compare display values: clipped to `[0, 1]` and
/// sRGB-encoded. `relMSE` and SMAPE compare linear radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metrics {
    /// Mean absolute difference of display values, in `[0, 1]`.
    pub l1: f64,
    /// Peak signal-to-noise ratio of display values, in dB; at most 120.
    pub psnr: f64,
    /// Structural similarity of display values, in `[−1, 1]` (Wang et al. 2004).
    pub ssim: f64,
    /// Mean of `(x − r)² / (r̄² + 0.01)`, where `r̄` is the reference pixel's mean channel. Leaves
    /// out the worst 0.1 % of the pixels, where fireflies would drown out all others.
    pub relmse: f64,
    /// Mean of `|x − r| / (|x| + |r| + 0.01)`, in `[0, 1]`.
    pub smape: f64,
    /// Number of the image's pixels with a NaN or infinite channel; such channels count as 0.
    pub bad: usize,
    /// The same of the reference.
    pub bad_reference: usize,
}

/// Compares a linear, scene-referred image with its reference.
///
/// # Errors
/// Fails if the two differ in size.
pub fn compare(image: &Image, reference: &Image) -> Result<Metrics> {
    if image.size() != reference.size() {
        let ((w, h), (rw, rh)) = (image.size(), reference.size());
        return Err(Error::Image(format!(
            "an image of {w}×{h} cannot be compared with a reference of {rw}×{rh}; \
             give two images of the same size"
        )));
    }
    let scale = exposure(reference);
    let (x, r) = (scaled(image, scale), scaled(reference, scale));
    let (shown_x, shown_r) = (displayed(&x), displayed(&r));
    Ok(Metrics {
        l1: mean(pairs(&shown_x, &shown_r).map(|(x, r)| (x - r).abs())),
        psnr: psnr(mean(pairs(&shown_x, &shown_r).map(|(x, r)| (x - r).powi(2)))),
        ssim: ssim::ssim(&shown_x, &shown_r, image.width() as usize),
        relmse: relmse(&x, &r),
        smape: mean(pairs(&x, &r).map(|(x, r)| (x - r).abs() / (x.abs() + r.abs() + 0.01))),
        bad: bad(image),
        bad_reference: bad(reference),
    })
}

fn bad(image: &Image) -> usize {
    image.pixels().iter().filter(|p| p.iter().any(|v| !v.is_finite())).count()
}

type Pixel = [f64; 3];

/// The factor that brings the log-average luminance of the lit pixels to 0.18; 1 for a black image.
///
/// [`compare`] scales both images by the reference's factor.
#[must_use]
pub fn exposure(image: &Image) -> f64 {
    let luminance = |p: &Pixel| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
    let lit: Vec<f64> = scaled(image, 1.0).iter().map(luminance).filter(|&l| l > 1e-8).collect();
    if lit.is_empty() { 1.0 } else { 0.18 / mean(lit.iter().map(|l| l.ln())).exp() }
}

/// The pixels times `scale`, with non-finite channels set to 0.
fn scaled(image: &Image, scale: f64) -> Vec<Pixel> {
    let value = |v: f32| if v.is_finite() { f64::from(v) * scale } else { 0.0 };
    image.pixels().iter().map(|pixel| pixel.map(value)).collect()
}

fn displayed(pixels: &[Pixel]) -> Vec<Pixel> {
    pixels.iter().map(|pixel| pixel.map(srgb)).collect()
}

/// The sRGB curve (IEC 61966-2-1), after clipping to `[0, 1]`.
fn srgb(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Pairs up the values of two images.
fn pairs<'a>(x: &'a [Pixel], r: &'a [Pixel]) -> impl ExactSizeIterator<Item = (f64, f64)> + 'a {
    let values = x.as_flattened().iter().copied();
    values.zip(r.as_flattened().iter().copied())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// In dB, for a peak of 1.
fn psnr(mean_square_error: f64) -> f64 {
    -10.0 * mean_square_error.max(1e-12).log10()
}

fn relmse(x: &[Pixel], r: &[Pixel]) -> f64 {
    let mut errors: Vec<f64> = x.iter().zip(r).map(|(x, r)| pixel_relmse(x, r)).collect();
    errors.sort_unstable_by(f64::total_cmp);
    errors.truncate((errors.len() * 999 / 1000).max(1));
    mean(errors.into_iter())
}

fn pixel_relmse(x: &Pixel, r: &Pixel) -> f64 {
    let square_error: f64 = x.iter().zip(r).map(|(x, r)| (x - r).powi(2)).sum();
    let brightness = r.iter().sum::<f64>() / 3.0;
    square_error / 3.0 / (brightness.powi(2) + 0.01)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(pixel: [f32; 3]) -> Image {
        Image::filled(2, 3, pixel).expect("a valid image")
    }

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "found {found}, not {expected}");
    }

    #[test]
    fn an_image_equals_itself() {
        let image = filled([0.1, 5.0, 0.0]);
        let (bad, bad_reference) = (0, 0);
        let expected = Metrics {
            l1: 0.0,
            psnr: 120.0,
            ssim: 1.0,
            relmse: 0.0,
            smape: 0.0,
            bad,
            bad_reference,
        };
        assert_eq!(compare(&image, &image).expect("one size"), expected);
    }

    #[test]
    fn known_figures_of_even_images() {
        // The reference is scaled by 0.09 to 0.18, and so the image to 0.36.
        let found = compare(&filled([4.0; 3]), &filled([2.0; 3])).expect("one size");
        let difference = srgb(0.36) - srgb(0.18);
        assert_near(found.l1, difference);
        assert_near(found.psnr, 20.0 * (1.0 / difference).log10());
        assert_near(found.relmse, 0.18 * 0.18 / (0.18 * 0.18 + 0.01));
        assert_near(found.smape, 0.18 / 0.55);
    }

    #[test]
    fn the_srgb_curve_has_its_published_values() {
        assert_near(srgb(0.002), 0.025_84);
        assert_near(srgb(0.18), 0.461_356_129_5);
        assert_near(srgb(7.0), 1.0);
    }

    #[test]
    fn exposure_is_the_mean_logarithm_of_what_is_lit() {
        let mut image = filled([0.0; 3]);
        image.pixels_mut()[1] = [4e-4; 3];
        image.pixels_mut()[2] = [1e-9; 3];
        image.pixels_mut()[4] = [0.0, 1e4 / 0.7152, 0.0];
        assert_near(exposure(&image), 0.09);
        assert_near(exposure(&filled([0.0; 3])), 1.0);
    }

    #[test]
    fn broken_pixels_are_counted_and_scored_as_black() {
        let reference = filled([2.0; 3]);
        let (mut broken, mut black) = (reference.clone(), reference.clone());
        broken.pixels_mut()[2] = [f32::NAN, 2.0, f32::INFINITY];
        black.pixels_mut()[2] = [0.0, 2.0, 0.0];
        let found = compare(&broken, &reference).expect("one size");
        assert_eq!(found, Metrics { bad: 1, ..compare(&black, &reference).expect("one size") });
        let found = compare(&reference, &broken).expect("one size");
        assert_eq!((found.bad, found.bad_reference), (0, 1));
    }

    #[test]
    fn the_worst_thousandth_of_the_pixels_does_not_count_in_relmse() {
        let reference = vec![[1.0; 3]; 2000];
        let mut image = reference.clone();
        image[7] = [1e9; 3];
        image[1234] = [1e9; 3];
        assert_near(relmse(&image, &reference), 0.0);
        image[99] = [2.0; 3];
        assert_near(relmse(&image, &reference), 1.0 / 1.01 / 1998.0);
    }

    /// A ramp plus a pattern, matched by the Python code that computed the expected values.
    fn ramp(pattern: u16) -> Image {
        let value = |x: u16, y: u16, c: u16| {
            x + 3 * y + 5 * c + pattern * ((x * 37 + y * 101 + c * 53) % 7)
        };
        let pixel = |i: u16| [0, 1, 2].map(|c| f32::from(value(i % 24, i / 24, c)) / 64.0);
        Image::new(24, 20, (0..24 * 20).map(pixel).collect()).expect("a valid image")
    }

    #[test]
    fn figures_agree_with_numpy_and_scikit_image() {
        // Computed with numpy 2.4.6 and structural_similarity of scikit-image 0.26.0.
        let found = compare(&ramp(3), &ramp(0)).expect("one size");
        assert_near(found.l1, 0.046_064_958_952);
        assert_near(found.psnr, 24.862_983_699_960);
        assert_near(found.ssim, 0.715_449_837_924);
        assert_near(found.relmse, 0.062_775_895_730);
        assert_near(found.smape, 0.102_912_735_755);
    }

    #[test]
    fn images_of_two_sizes_are_refused() {
        let other = Image::filled(3, 2, [1.0; 3]).expect("a valid image");
        let error = compare(&filled([1.0; 3]), &other).expect_err("two sizes").to_string();
        assert!(error.contains("2×3") && error.contains("3×2"), "{error}");
    }
}
