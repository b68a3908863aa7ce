//! A further layer, such as a light group, shown in place of the color. Its images are uploaded to
//! the GPU on another thread.

use std::sync::Arc;

use wgdenoise::Image;

use crate::denoise::Outcome;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::Opened;

/// The layer to show, and the one that is ready.
#[derive(Default)]
pub(crate) struct Further {
    /// The name of the layer to show; `None` shows the color.
    pub(crate) chosen: Option<String>,
    asked: Option<Source>,
    found: Option<Layer>,
}

/// A layer that is ready to show.
pub(crate) struct Layer {
    source: Source,
    noisy: Texture,
    denoised: Option<Texture>,
}

/// Where to find a layer's images.
#[derive(Clone)]
pub(crate) struct Source {
    opened: Arc<Opened>,
    outcome: Option<Arc<Outcome>>,
    /// Index among the view's further layers.
    index: usize,
}

impl Further {
    /// The chosen layer of this file; `None` for the color, or until the layer is on the GPU.
    pub(crate) fn of(&self, opened: &Arc<Opened>) -> Option<&Layer> {
        self.found.as_ref().filter(|layer| Arc::ptr_eq(&layer.source.opened, opened))
    }

    /// Notes the file and its result. Returns what to upload to the GPU if the layer, the file or
    /// the result has changed.
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

    /// Finds the chosen layer by name, if the file has it.
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

    /// Uploads the images to the GPU.
    ///
    /// # Errors
    /// If the adapter is out of memory.
    pub(crate) fn upload(self, gpu: &Gpu) -> Result<Layer, String> {
        let noisy = Texture::upload(gpu, self.noisy())?;
        let denoised = self.denoised().map(|image| Texture::upload(gpu, image)).transpose()?;
        Ok(Layer { source: self, noisy, denoised })
    }
}
