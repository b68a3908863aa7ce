//! A further layer, such as a light group, that is shown in place of the color: its images are put on the
//! GPU on a thread of their own.

use std::sync::Arc;

use wgdenoise::Image;

use crate::denoise::Outcome;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::Opened;
use crate::session::Session;
use crate::work::Report;

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
struct Source {
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

    fn upload(self, gpu: &Gpu) -> Result<Layer, String> {
        let noisy = Texture::upload(gpu, self.noisy())?;
        let denoised = self.denoised().map(|image| Texture::upload(gpu, image)).transpose()?;
        Ok(Layer { source: self, noisy, denoised })
    }
}

impl Session {
    /// Has the chosen layer put on the GPU whenever it, the file or the result changes.
    pub(crate) fn keep_further(&mut self) {
        let wanted = self.chosen_layer();
        let is_asked = match (&wanted, &self.further.asked) {
            (Some(wanted), Some(asked)) => wanted.is_same(asked),
            (wanted, asked) => wanted.is_none() && asked.is_none(),
        };
        if is_asked {
            return;
        }
        self.further.asked.clone_from(&wanted);
        match wanted {
            None => self.further.found = None,
            Some(source) => {
                let gpu = self.gpu.clone();
                self.in_background(move || Report::Further(source.upload(&gpu)));
            }
        }
    }

    /// The layer that was chosen by its name, if the file has it.
    fn chosen_layer(&self) -> Option<Source> {
        let (name, opened) = (self.further.chosen.as_ref()?, self.opened()?);
        let index = opened.view().layers().iter().position(|layer| layer.name == *name)?;
        Some(Source { opened: opened.clone(), outcome: self.denoised.clone(), index })
    }
}
