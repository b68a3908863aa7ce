//! A further layer, such as a light group, that is shown in place of the color: its images are put on the
//! GPU on a thread of their own.

use std::sync::Arc;

use wgdenoise::Image;

use crate::denoise::Outcome;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::Opened;

/// Which layer is to be shown, and the one that is.
#[derive(Default)]
pub(crate) struct Further {
    /// The name of the layer to show; the color without one.
    pub(crate) chosen: Option<String>,
    asked: Option<Source>,
    found: Option<Layer>,
}

/// A layer that can be shown.
pub(crate) struct Layer {
    source: Source,
    noisy: Texture,
    denoised: Option<Texture>,
}

/// Where a layer's images are.
#[derive(Clone)]
pub(crate) struct Source {
    opened: Arc<Opened>,
    outcome: Option<Arc<Outcome>>,
    /// The position among the view's further layers.
    index: usize,
}

impl Further {
    /// The chosen layer of this file; `None` for the color, and until the layer is on the GPU.
    pub(crate) fn of(&self, opened: &Arc<Opened>) -> Option<&Layer> {
        self.found.as_ref().filter(|layer| Arc::ptr_eq(&layer.source.opened, opened))
    }

    /// Takes note of the file and its result. Returns what has to be put on the GPU because the layer,
    /// the file or the result is another one.
    pub(crate) fn ask(
        &mut self,
        opened: Option<&Arc<Opened>>,
        outcome: Option<&Arc<Outcome>>,
    ) -> Option<Source> {
        let wanted = opened.and_then(|opened| self.wanted(opened, outcome));
        let Some(source) = wanted else {
            (self.asked, self.found) = (None, None);
            return None;
        };
        let is_asked = self.asked.as_ref().is_some_and(|asked| asked.is_same(&source));
        self.asked = Some(source.clone());
        (!is_asked).then_some(source)
    }

    /// The layer that was chosen by its name, if the file has it.
    fn wanted(&self, opened: &Arc<Opened>, outcome: Option<&Arc<Outcome>>) -> Option<Source> {
        let name = self.chosen.as_ref()?;
        let index = opened.view().layers().iter().position(|layer| layer.name == *name)?;
        Some(Source { opened: opened.clone(), outcome: outcome.cloned(), index })
    }

    /// Takes a layer, unless another one has been chosen since.
    pub(crate) fn take(&mut self, layer: Layer) {
        if self.asked.as_ref().is_some_and(|asked| asked.is_same(&layer.source)) {
            self.found = Some(layer);
        }
    }
}

impl Layer {
    pub(crate) fn name(&self) -> &str {
        &self.source.opened.view().layers()[self.source.index].name
    }

    pub(crate) fn noisy(&self) -> (&Image, &Texture) {
        (self.source.noisy(), &self.noisy)
    }

    pub(crate) fn denoised(&self) -> Option<(&Image, &Texture)> {
        self.source.denoised().zip(self.denoised.as_ref())
    }
}

impl Source {
    fn is_same(&self, other: &Self) -> bool {
        let pointer = |source: &Self| source.outcome.as_ref().map(Arc::as_ptr);
        self.index == other.index
            && Arc::ptr_eq(&self.opened, &other.opened)
            && pointer(self) == pointer(other)
    }

    fn noisy(&self) -> &Image {
        &self.opened.view().layers()[self.index].image
    }

    fn denoised(&self) -> Option<&Image> {
        self.outcome.as_ref()?.results[self.opened.shown].layers.get(self.index)
    }

    /// Puts the images on the GPU.
    ///
    /// # Errors
    /// If the adapter has no memory for them.
    pub(crate) fn upload(self, gpu: &Gpu) -> Result<Layer, String> {
        let noisy = Texture::upload(gpu, self.noisy())?;
        let denoised = self.denoised().map(|image| Texture::upload(gpu, image)).transpose()?;
        Ok(Layer { source: self, noisy, denoised })
    }
}
