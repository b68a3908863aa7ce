//! The CPU images of one view.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};
use crate::image::Image;
use crate::model::Inputs;

/// The images of one view on the CPU, all the same size.
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
    /// Linear, scene-referred color.
    pub color: &'a Image,
    /// Linear albedo in `[0, 1]`.
    pub albedo: Option<&'a Image>,
    /// Normal with components in `[−1, 1]`, in camera or world space.
    pub normal: Option<&'a Image>,
    /// The factor, above 0, that brings color to the exposure the network was trained at. `None`
    /// measures it, or uses 1 for weights that do not read unbounded light
    /// ([`TransferFunction::is_hdr`](crate::TransferFunction::is_hdr)).
    pub input_scale: Option<f32>,
    /// Whether the left and the right edge touch, as in a latlong panorama.
    pub panorama: bool,
    /// Further linear images of the view, filtered with the color's kernels by
    /// [`Denoiser::denoise_layers`](crate::Denoiser::denoise_layers).
    pub layers: &'a [&'a Image],
    /// Alpha, row by row, denoised like a layer. The color is premultiplied by it.
    pub alpha: Option<&'a [f32]>,
    /// Once this is true, the blocking calls end with
    /// [`Error::Stopped`](crate::Error::Stopped) after at most three more submissions.
    pub stop: Option<&'a AtomicBool>,
    /// Whether the last layer is alpha, which is not light.
    pub(crate) ends_in_alpha: bool,
}

/// A denoised frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Denoised {
    /// The color.
    pub color: Image,
    /// The frame's layers, in its order.
    pub layers: Vec<Image>,
    /// The frame's alpha.
    pub alpha: Option<Vec<f32>>,
}

/// The images of a frame besides its color, on which its memory depends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// The auxiliary images.
    pub inputs: Inputs,
    /// Whether there are further layers or alpha. Their number does not matter.
    pub layers: bool,
}

impl From<Inputs> for Contents {
    fn from(inputs: Inputs) -> Self {
        Self { inputs, layers: false }
    }
}

impl<'a> Frame<'a> {
    /// Color alone, with measured exposure.
    #[must_use]
    pub fn new(color: &'a Image) -> Self {
        Self {
            color,
            albedo: None,
            normal: None,
            input_scale: None,
            panorama: false,
            layers: &[],
            alpha: None,
            stop: None,
            ends_in_alpha: false,
        }
    }

    /// Sets or clears the albedo.
    #[must_use]
    pub fn albedo(self, albedo: impl Into<Option<&'a Image>>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// Sets or clears the normal.
    #[must_use]
    pub fn normal(self, normal: impl Into<Option<&'a Image>>) -> Self {
        Self { normal: normal.into(), ..self }
    }

    /// Sets the input scale; `None` measures it.
    #[must_use]
    pub fn input_scale(self, scale: impl Into<Option<f32>>) -> Self {
        Self { input_scale: scale.into(), ..self }
    }

    /// Sets whether the left and right edges touch, so that the seam is denoised like any other
    /// place. A `Pass` has no such setting; give it a wider image.
    #[must_use]
    pub fn panorama(self, panorama: bool) -> Self {
        Self { panorama, ..self }
    }

    /// Sets the further layers: images that are linear in the color's samples, such as light groups
    /// or direct and indirect light. Unlike alpha, they all count as light: weights that demodulate
    /// multiply their means by the surface's texture.
    #[must_use]
    pub fn layers(self, layers: &'a [&'a Image]) -> Self {
        Self { layers, ..self }
    }

    /// Sets or clears the alpha: one value per pixel, row by row.
    #[must_use]
    pub fn alpha(self, alpha: impl Into<Option<&'a [f32]>>) -> Self {
        Self { alpha: alpha.into(), ..self }
    }

    /// Sets a flag with which another thread can stop this frame.
    #[must_use]
    pub fn stop(self, stop: impl Into<Option<&'a AtomicBool>>) -> Self {
        Self { stop: stop.into(), ..self }
    }
}

impl Frame<'_> {
    /// The auxiliary images that this frame has.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    /// The images of the frame besides its color.
    #[must_use]
    pub fn contents(&self) -> Contents {
        Contents { inputs: self.inputs(), layers: !self.layers.is_empty() || self.alpha.is_some() }
    }

    /// The layers in order, each paired with whether it is light.
    pub(crate) fn kinds(&self) -> impl Iterator<Item = (&Image, bool)> {
        let lights = self.layers.len() - usize::from(self.ends_in_alpha);
        self.layers.iter().enumerate().map(move |(i, layer)| (*layer, i < lights))
    }

    /// Fails if the caller has asked to stop.
    pub(crate) fn check_stop(&self) -> Result<()> {
        let stopped = self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
        if stopped { Err(Error::Stopped) } else { Ok(()) }
    }

    /// Rejects images of different sizes and invalid input scales.
    pub(crate) fn check(&self) -> Result<()> {
        let auxiliary = [("albedo", self.albedo), ("normal", self.normal)];
        let layers = self.layers.iter().map(|layer| ("a layer", Some(*layer)));
        for (name, image) in auxiliary.into_iter().chain(layers) {
            let Some(image) = image else { continue };
            if image.size() != self.color.size() {
                let ((aw, ah), (w, h)) = (image.size(), self.color.size());
                return Err(Error::Image(format!(
                    "{name} is {aw}×{ah}, but the color is {w}×{h}; they must be the same size"
                )));
            }
        }
        let pixels = self.color.pixels().len();
        if let Some(alpha) = self.alpha.filter(|alpha| alpha.len() != pixels) {
            let given = alpha.len();
            return Err(Error::Image(format!(
                "alpha has {given} values, but the color has {pixels} pixels"
            )));
        }
        check_input_scale(self.input_scale)
    }
}

/// Rejects scales that are not positive, finite and normal: many GPUs flush subnormals to 0.
pub(crate) fn check_input_scale(scale: Option<f32>) -> Result<()> {
    match scale {
        Some(scale) if !(scale.is_normal() && scale > 0.0) => Err(Error::Image(format!(
            "input scale is {scale}, expected a number from 1.2e-38 to 3.4e38"
        ))),
        _ => Ok(()),
    }
}
