//! The images of a view: from Python, and for the engine.

use pyo3::prelude::*;
use wgdenoise::Image;

use crate::arrays::{self, Srgb};
use crate::errors;

/// The images as Python passes them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Given<'py> {
    color: Bound<'py, PyAny>,
    albedo: Option<Bound<'py, PyAny>>,
    normal: Option<Bound<'py, PyAny>>,
    /// Each with its name in messages.
    layers: Vec<(String, Bound<'py, PyAny>)>,
    alpha: Option<Bound<'py, PyAny>>,
    /// Whether to decode `uint8` arrays as sRGB.
    srgb: bool,
}

/// The images as the engine takes them.
pub(crate) struct Images {
    pub(crate) color: Image,
    pub(crate) albedo: Option<Image>,
    pub(crate) normal: Option<Image>,
    pub(crate) layers: Vec<Image>,
    pub(crate) alpha: Option<Vec<f32>>,
    /// Whether alpha is the color's fourth channel.
    pub(crate) has_fourth_channel: bool,
}

impl Images {
    /// Reads the arrays.
    ///
    /// # Errors
    /// If an array cannot be used, alpha is passed twice, or `srgb` is set but no array needs
    /// decoding.
    pub(crate) fn read(py: Python<'_>, given: &Given<'_>) -> PyResult<Self> {
        let srgb = Srgb::new(given.srgb);
        let picture = arrays::picture("color", &given.color, &srgb)?;
        let size = picture.image.size();
        let alpha = given.alpha.as_ref().map(|array| arrays::alpha(array, size)).transpose()?;
        if alpha.is_some() && picture.alpha.is_some() {
            let what = "alpha is given twice: by itself and as the fourth channel of color";
            return Err(errors::of_usage(py, what));
        }
        let layers = given.layers.iter().map(|(name, array)| arrays::rgb(name, array, &srgb));
        let images = Self {
            color: picture.image,
            albedo: optional("albedo", given.albedo.as_ref(), &srgb)?,
            normal: optional("normal", given.normal.as_ref(), &Srgb::new(false))?,
            layers: layers.collect::<PyResult<_>>()?,
            has_fourth_channel: picture.alpha.is_some(),
            alpha: picture.alpha.or(alpha),
        };
        if srgb.is_idle() {
            return Err(errors::of_usage(
                py,
                "srgb=True is for arrays of uint8, and there is none",
            ));
        }
        Ok(images)
    }

    /// The alpha to denoise, if any. As on the command line, alpha of only 0 and 1 has no noise.
    pub(crate) fn noisy_alpha(&self) -> Option<&[f32]> {
        let is_fractional = |alpha: &&[f32]| alpha.iter().any(|&a| a > 0.0 && a < 1.0);
        self.alpha.as_deref().filter(is_fractional)
    }
}

fn optional(name: &str, array: Option<&Bound<'_, PyAny>>, srgb: &Srgb) -> PyResult<Option<Image>> {
    array.map(|array| arrays::rgb(name, array, srgb)).transpose()
}
