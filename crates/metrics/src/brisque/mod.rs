//! BRISQUE, a score without a reference: Mittal, Moorthy and Bovik, "No-Reference Image Quality
//! Assessment in the Spatial Domain", IEEE Transactions on Image Processing 21(12), 2012.
//!
//! The 36 features are the paper's. The regressor is our own, fitted to our renders in place of the
//! paper's photographs by `training/quality/brisque.py`, which computes the same features.

use wgdenoise::{Error, Image, Result};

use self::features::{COUNT, SMALLEST, features};
use super::{displayed, scaled};

mod distribution;
mod features;
mod table;

/// Added to variances, which may be 0, before taking their logarithm.
const FLOOR: f64 = 1e-3;

/// How noisy a linear, scene-referred image looks when displayed, from 0 (best) to 100: an estimate
/// of 100 (1 − SSIM) by BRISQUE (Mittal et al. 2012), which needs no reference.
///
/// The image is multiplied by `exposure`, clipped to `[0, 1]` and sRGB-encoded. Only compare scores
/// at the same exposure: use the [`exposure`](crate::exposure) of the reference or, without one, of
/// the denoised image. NaN and infinite channels count as 0.
///
/// Trust it to tell plainly noisy pictures of one view apart, and for little else:
/// `docs/brisque.md` has its record. It sees neither wrong brightness nor missing objects.
///
/// # Errors
/// Fails if a side is shorter than 14 pixels, if the displayed picture has one brightness only, or
/// if the exposure is not a positive number.
pub fn brisque(image: &Image, exposure: f64) -> Result<f64> {
    let luma = luma(image, exposure)?;
    Ok(score(&features(&luma, image.width() as usize)))
}

/// The luma of the displayed picture, or an error if it cannot be judged.
fn luma(image: &Image, exposure: f64) -> Result<Vec<f64>> {
    let (width, height) = image.size();
    let refuse = |reason: String| Err(Error::Image(format!("BRISQUE cannot judge {reason}")));
    if (width.min(height) as usize) < SMALLEST {
        return refuse(format!("{width}×{height} pixels; it needs {SMALLEST}×{SMALLEST} or more"));
    }
    if !(exposure.is_finite() && exposure > 0.0) {
        return refuse(format!("a picture at exposure {exposure}; give a positive number"));
    }
    let shown = displayed(&scaled(image, exposure));
    let luma: Vec<f64> =
        shown.iter().map(|p| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]).collect();
    if luma.iter().all(|&v| v == luma[0]) {
        return refuse("a picture of one brightness; it has no structure".into());
    }
    Ok(luma)
}

/// The regressor: a sum of bumps around typical pictures in feature space.
fn score(features: &[f64; COUNT]) -> f64 {
    let x = inputs(features);
    let bump = |center: &[i16; COUNT]| {
        let distance = |(x, center): (&f64, &i16)| (x - f64::from(*center) / 1e3).powi(2);
        (-table::GAMMA * x.iter().zip(center).map(distance).sum::<f64>()).exp()
    };
    let bumps = table::CENTERS.iter().zip(table::WEIGHTS);
    let sum: f64 = bumps.map(|(center, weight)| weight * bump(center)).sum();
    (table::OFFSET + sum).clamp(0.0, 100.0)
}

/// The regressor's inputs: the features, variances as logarithms, standardized by mean and
/// deviation over the training pictures.
fn inputs(features: &[f64; COUNT]) -> [f64; COUNT] {
    std::array::from_fn(|i| {
        let value = if is_variance(i) { (features[i] + FLOOR).ln() } else { features[i] };
        (value - table::MEAN[i]) / table::DEVIATION[i]
    })
}

/// Whether a feature is a variance: at either size, the second one and the last two of each
/// product's four.
fn is_variance(feature: usize) -> bool {
    match feature % 18 {
        0 => false,
        1 => true,
        product => (product - 2) % 4 > 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use safetensors::SafeTensors;

    /// Written by `training/quality/brisque.py`, in 64 bits except for the pictures.
    const FIXTURE: &[u8] = include_bytes!("../../tests/brisque.safetensors");

    fn values(tensor: &str) -> Vec<f64> {
        let file = SafeTensors::deserialize(FIXTURE).expect("a fixture is safetensors");
        let (values, _) = file.tensor(tensor).expect(tensor).data().as_chunks();
        values.iter().map(|&v| f64::from_le_bytes(v)).collect()
    }

    fn picture(name: &str) -> Image {
        let file = SafeTensors::deserialize(FIXTURE).expect("a fixture is safetensors");
        let tensor = file.tensor(name).expect(name);
        let [3, height, width] = tensor.shape()[..] else { panic!("{name}: {:?}", tensor.shape()) };
        let (values, _) = tensor.data().as_chunks();
        let value = |c: usize, i: usize| f32::from_le_bytes(values[c * width * height + i]);
        let pixels = (0..width * height).map(|i| [0, 1, 2].map(|c| value(c, i))).collect();
        Image::new(width as u32, height as u32, pixels).expect("a valid image")
    }

    /// A picture with structure, of any size.
    fn stripes(width: u32, height: u32) -> Image {
        let pixel = |i| if i % width % 5 < 2 { [0.1; 3] } else { [0.6; 3] };
        Image::new(width, height, (0..width * height).map(pixel).collect()).expect("a valid image")
    }

    #[test]
    fn features_and_scores_agree_with_numpy() {
        let exposure = values("exposure")[0];
        for name in ["noise", "edges", "smooth"] {
            let image = picture(name);
            let luma = luma(&image, exposure).expect("it can be judged");
            let found = features(&luma, image.width() as usize);
            for (found, expected) in found.iter().zip(values(&format!("{name}.features"))) {
                assert!((found - expected).abs() < 1e-9, "{name}: {found}, not {expected}");
            }
            let found = brisque(&image, exposure).expect("it can be judged");
            let expected = values(&format!("{name}.score"))[0];
            assert!((found - expected).abs() < 1e-6, "{name}: {found}, not {expected}");
        }
    }

    #[test]
    fn every_fourth_variance_of_either_size_is_found() {
        let found: Vec<_> = (0..COUNT).filter(|&i| is_variance(i)).collect();
        let of_one_size = [1, 4, 5, 8, 9, 12, 13, 16, 17];
        assert_eq!(found, [of_one_size, of_one_size.map(|i| i + 18)].concat());
    }

    #[test]
    fn what_has_no_structure_is_refused() {
        for (level, exposure) in [(0.0, 1.0), (0.3, 1.0), (7.0, 1.0), (f32::NAN, 1.0)] {
            let image = Image::filled(20, 20, [level; 3]).expect("a valid image");
            let error = brisque(&image, exposure).expect_err("one brightness").to_string();
            assert!(error.contains("one brightness"), "{error}");
        }
        brisque(&stripes(20, 20), 100.0).expect_err("all of it is clipped to white");
    }

    #[test]
    fn pictures_smaller_than_the_window_are_refused() {
        for (width, height) in [(13, 40), (40, 13), (1, 1)] {
            let error = brisque(&stripes(width, height), 1.0).expect_err("too small").to_string();
            assert!(error.contains(&format!("{width}×{height}")), "{error}");
        }
        let score = brisque(&stripes(14, 14), 1.0).expect("just large enough");
        assert!((0.0..=100.0).contains(&score));
    }

    #[test]
    fn exposures_that_are_no_positive_numbers_are_refused() {
        for exposure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = brisque(&stripes(20, 20), exposure).expect_err("it is dark").to_string();
            assert!(error.contains("positive"), "{error}");
        }
    }

    #[test]
    fn broken_channels_count_as_black() {
        let (mut broken, mut black) = (stripes(20, 20), stripes(20, 20));
        broken.pixels_mut()[50] = [f32::NAN, 0.6, f32::NEG_INFINITY];
        black.pixels_mut()[50] = [0.0, 0.6, 0.0];
        let of = |image| brisque(image, 1.0).expect("it can be judged");
        assert_eq!(of(&broken), of(&black));
    }
}
