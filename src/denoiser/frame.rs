//! The images of one view, on the CPU.

use crate::error::{Error, Result};
use crate::image::Image;
use crate::model::Inputs;

/// Images of one view.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Linear, scene-referred colour.
    pub color: &'a Image,
    /// Albedo in `[0, 1]`, if there is one.
    pub albedo: Option<&'a Image>,
    /// Normal in `[−1, 1]`, if there is one.
    pub normal: Option<&'a Image>,
    /// What colour is multiplied by for the network; `None` measures it, or is 1 for weights that do
    /// not read light of any size.
    pub input_scale: Option<f32>,
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
