//! The visible error: FLIP between the reference and what the window shows.

use std::sync::Arc;

use wgdenoise::Image;
use wgdenoise_metrics::{PIXELS_PER_DEGREE, flip};

use crate::denoise::Outcome;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::Opened;
use crate::state::magma::magma;
use crate::state::tone::{Curve, Tone, light_of};

/// The visible errors of the open image.
pub(crate) struct Perceived {
    /// The mean errors of the noisy and the denoised image, from 0 to 1.
    pub(crate) means: [f64; 2],
    /// The denoised image's errors, row by row.
    pub(crate) errors: Vec<f32>,
    /// The same errors as a color map, in linear light.
    pub(crate) map: Image,
    pub(crate) texture: Texture,
}

/// Everything the errors depend on.
#[derive(Clone)]
pub(crate) struct Asked {
    pub(crate) opened: Arc<Opened>,
    pub(crate) outcome: Arc<Outcome>,
    pub(crate) reference: Arc<Image>,
    pub(crate) exposure: f32,
}

impl Asked {
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.exposure == other.exposure && self.has_images_of(other)
    }

    pub(crate) fn has_images_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.opened, &other.opened)
            && Arc::ptr_eq(&self.outcome, &other.outcome)
            && Arc::ptr_eq(&self.reference, &other.reference)
    }

    /// Compares both images with the reference.
    ///
    /// # Errors
    /// If the sizes differ, or the adapter has no memory for the map.
    pub(crate) fn compute(&self, gpu: &Gpu) -> Result<Perceived, String> {
        let tone = Tone { exposure: self.exposure, curve: Curve::Srgb };
        let reference = displayed(&self.reference, tone)?;
        let error = |image: &Image| {
            let found = flip(&displayed(image, tone)?, &reference, PIXELS_PER_DEGREE);
            found.map_err(|error| error.to_string())
        };
        let noisy = error(self.opened.view().color())?;
        let denoised = error(&self.outcome.results[self.opened.shown].color)?;
        let colors = denoised.errors.iter().map(|&error| magma(error).map(light_of)).collect();
        let map = image(&self.reference, colors)?;
        let texture = Texture::upload(gpu, &map)?;
        let means = [noisy.mean, denoised.mean];
        Ok(Perceived { means, errors: denoised.errors, map, texture })
    }
}

/// Converts light to screen values.
fn displayed(light: &Image, tone: Tone) -> Result<Image, String> {
    image(light, light.pixels().iter().map(|pixel| tone.screen(*pixel)).collect())
}

/// Makes an image of the same size as another.
fn image(like: &Image, pixels: Vec<[f32; 3]>) -> Result<Image, String> {
    Image::new(like.width(), like.height(), pixels).map_err(|error| error.to_string())
}
