//! The images that can be shown, on the CPU and on the GPU.

use wgdenoise::Image;

use crate::further::Layer;
use crate::gpu::texture::Texture;
use crate::perceived::Perceived;
use crate::session::Session;
use crate::state::looking::{Available, Measure, Shown};

impl Session {
    /// The images available besides the noisy one.
    pub(crate) fn available(&self) -> Available {
        let has_result = self.denoised.is_some();
        Available {
            denoised: self.layer().map_or(has_result, |layer| layer.denoised().is_some()),
            reference: self.reference.is_some() && self.misfit().is_none(),
            albedo: self.loaded.as_ref().is_some_and(|loaded| loaded.albedo.is_some()),
            normal: self.loaded.as_ref().is_some_and(|loaded| loaded.normal.is_some()),
        }
    }

    /// Why the reference cannot be compared with the open image; `None` if it can.
    pub(crate) fn misfit(&self) -> Option<String> {
        let (reference, [w, h]) = (self.reference.as_ref()?, self.opened()?.size());
        let (rw, rh) = reference.image.size();
        let name = reference.name();
        let why = || format!("{name} has {rw}×{rh} pixels, not {w}×{h}; open another reference");
        ((rw, rh) != (w, h)).then(why)
    }

    /// The further layer shown in place of the color.
    pub(crate) fn layer(&self) -> Option<&Layer> {
        self.further.of(self.opened()?)
    }

    /// The visible errors, if the difference shows them.
    pub(crate) fn perceived(&self) -> Option<&Perceived> {
        self.perceiving.found().filter(|_| self.wants_perceived())
    }

    /// Whether the difference is to show visible errors. Further layers have none: the reference
    /// belongs to the color.
    pub(crate) fn wants_perceived(&self) -> bool {
        let has_both = self.subtracted() == Shown::Reference && self.denoised.is_some();
        has_both && self.looking.measure == Measure::Perceived
    }

    /// An image on the CPU; a difference of light uses the denoised image.
    pub(crate) fn image(&self, shown: Shown) -> Option<&Image> {
        let (opened, layer) = (self.opened()?, self.layer());
        match shown {
            Shown::Noisy => Some(layer.map_or(opened.view().color(), |layer| layer.noisy().0)),
            Shown::Difference if let Some(perceived) = self.perceived() => Some(&perceived.map),
            Shown::Denoised | Shown::Difference => match layer {
                Some(layer) => layer.denoised().map(|denoised| denoised.0),
                None => Some(&self.denoised.as_ref()?.results.get(opened.shown)?.color),
            },
            Shown::Reference => self.reference.as_ref().map(|reference| &*reference.image),
            Shown::Albedo => opened.view().albedo(),
            Shown::Normal => opened.view().normal(),
        }
    }

    /// An image on the GPU; a difference of light uses the denoised image.
    pub(crate) fn texture(&self, shown: Shown) -> Option<&Texture> {
        let (loaded, layer) = (self.loaded.as_ref()?, self.layer());
        match shown {
            Shown::Noisy => Some(layer.map_or(&loaded.noisy, |layer| layer.noisy().1)),
            Shown::Difference if let Some(perceived) = self.perceived() => Some(&perceived.texture),
            Shown::Denoised | Shown::Difference => match layer {
                Some(layer) => layer.denoised().map(|denoised| denoised.1),
                None => self.denoised.as_ref().map(|denoised| &denoised.texture),
            },
            Shown::Reference => self.reference.as_ref().map(|reference| &reference.texture),
            Shown::Albedo => loaded.albedo.as_ref(),
            Shown::Normal => loaded.normal.as_ref(),
        }
    }

    /// The image that the denoised one is compared with.
    pub(crate) fn subtracted(&self) -> Shown {
        let has_reference = self.available().reference && self.layer().is_none();
        if has_reference { Shown::Reference } else { Shown::Noisy }
    }
}
