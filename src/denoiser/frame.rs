//! The images of one view, on the CPU.

use crate::error::{Error, Result};
use crate::image::Image;
use crate::model::Inputs;

/// The images of one view, all of one size.
///
/// ```
/// use wgdenoise::{Frame, Image};
///
/// let [color, albedo] = [[4.0, 2.0, 1.0], [0.8, 0.4, 0.2]].map(|pixel| Image::filled(64, 48, pixel));
/// let (color, albedo) = (color?, albedo?);
/// let frame = Frame::new(&color).albedo(&albedo);
/// # Ok::<(), wgdenoise::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// Linear, scene-referred colour.
    pub color: &'a Image,
    /// Albedo in `[0, 1]`, if there is one.
    pub albedo: Option<&'a Image>,
    /// Normal in `[−1, 1]`, in camera or world space, if there is one.
    pub normal: Option<&'a Image>,
    /// The factor that brings colour to the exposure that the network was trained at; `None` measures
    /// it (1 for weights that do not read light of any brightness).
    pub input_scale: Option<f32>,
}

impl<'a> Frame<'a> {
    /// Colour alone, its exposure measured.
    #[must_use]
    pub fn new(color: &'a Image) -> Self {
        Self { color, albedo: None, normal: None, input_scale: None }
    }

    /// With this albedo, or none.
    #[must_use]
    pub fn albedo(self, albedo: impl Into<Option<&'a Image>>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// With this normal, or none.
    #[must_use]
    pub fn normal(self, normal: impl Into<Option<&'a Image>>) -> Self {
        Self { normal: normal.into(), ..self }
    }

    /// With this exposure, or a measured one.
    #[must_use]
    pub fn input_scale(self, scale: impl Into<Option<f32>>) -> Self {
        Self { input_scale: scale.into(), ..self }
    }
}

impl Frame<'_> {
    /// Which images there are.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    /// Refuses images of different sizes and scales that are none.
    pub(crate) fn check(&self) -> Result<()> {
        for (name, image) in [("albedo", self.albedo), ("normal", self.normal)] {
            let Some(image) = image else { continue };
            if image.size() != self.color.size() {
                let ((aw, ah), (w, h)) = (image.size(), self.color.size());
                return Err(Error::Image(format!(
                    "{name} is {aw}×{ah}, but the colour is {w}×{h}; both must have one size"
                )));
            }
        }
        check_input_scale(self.input_scale)
    }
}

/// Refuses scales that are no positive number. Subnormal ones count as 0 on many GPUs.
pub(crate) fn check_input_scale(scale: Option<f32>) -> Result<()> {
    match scale {
        Some(scale) if !(scale.is_normal() && scale > 0.0) => {
            Err(Error::Image(format!("input scale is {scale}, expected a number above 0")))
        }
        _ => Ok(()),
    }
}
