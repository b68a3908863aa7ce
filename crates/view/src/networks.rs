//! The networks for the current settings, on the window's device.

use std::path::PathBuf;

use wgdenoise::{
    Denoiser, Error, Frame, Image, Inputs, MainImage, MatrixShape, Options, Precision, Quality,
    Weights,
};
use wgdenoise_files::weights::{self, Subject};

use crate::gpu::host::Gpu;
use crate::open::sentence;
use crate::state::settings::{Settings, Source};
use crate::state::settling::Stamp;

/// The denoiser for the color and, if requested, the prefilters for albedo and normals.
#[derive(Debug)]
pub(crate) struct Networks {
    pub(crate) color: Denoiser,
    prefilter: Option<[Denoiser; 2]>,
}

/// Where weights come from.
#[derive(Clone, Debug, PartialEq)]
enum Origin {
    BuiltIn(Quality),
    /// A file with its stamp, so that it is read again after a change.
    File(PathBuf, Option<Stamp>),
}

/// What determines the networks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    color: Origin,
    prefilter: Option<[Origin; 2]>,
    precision: Precision,
    skip_clean: bool,
}

impl Key {
    /// Chooses the weights for an image with these inputs; `hdr` means that it is scene-referred.
    ///
    /// # Errors
    /// If the folder has no matching weights, or prefiltering lacks an input.
    pub(crate) fn of(settings: &Settings, inputs: Inputs, hdr: bool) -> Result<Self, String> {
        let clean = settings.prefilters();
        if clean && inputs != Inputs::ALL {
            return Err(format!("prefiltering needs albedo and normal, but there is {inputs}"));
        }
        let origin = |main| {
            let subject = Subject { main, inputs, hdr, clean };
            Origin::of(settings, subject)
        };
        let color = origin(MainImage::Color)?;
        let mut prefilter = None;
        if clean {
            prefilter = Some([origin(MainImage::Albedo)?, origin(MainImage::Normal)?]);
        }
        Ok(Self {
            color,
            prefilter,
            precision: settings.precision,
            skip_clean: settings.skip_clean,
        })
    }

    /// A notice about the choice for the user.
    pub(crate) fn notice(&self, settings: &Settings) -> Option<String> {
        match (&self.color, &settings.weights) {
            (Origin::File(path, _), Source::Folder(_)) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                Some(format!("weights: {}", wgdenoise_files::escaped(&name)))
            }
            _ => None,
        }
    }
}

impl Origin {
    fn of(settings: &Settings, subject: Subject) -> Result<Self, String> {
        let path = match &settings.weights {
            Source::BuiltIn => return Ok(Self::BuiltIn(settings.quality)),
            Source::File(path) => path.clone(),
            Source::Folder(folder) => weights::choose(folder, subject, Some(settings.quality))
                .map_err(|error| sentence(&error))?,
        };
        let stamp = Stamp::of(&path);
        Ok(Self::File(path, stamp))
    }

    fn load(&self) -> Result<Weights, String> {
        match self {
            Self::BuiltIn(quality) => Weights::builtin(*quality).map_err(|e| e.to_string()),
            Self::File(path, _) => weights::load(path).map_err(|error| sentence(&error)),
        }
    }
}

impl Networks {
    /// Reads the weights and compiles the kernels.
    ///
    /// # Errors
    /// The sentence on the file, or the engine's error.
    pub(crate) fn new(gpu: &Gpu, key: &Key) -> Result<Self, String> {
        let Gpu { adapter, device, queue, .. } = gpu;
        let options = Options::default()
            .precision(key.precision)
            .skip_clean(key.skip_clean)
            .keep_memory(false)
            .matrix(MatrixShape::of(adapter, key.precision));
        let denoiser = |origin: &Origin| {
            let made = Denoiser::new(device, queue, &origin.load()?, &options);
            made.map_err(|error| error.to_string())
        };
        let color = denoiser(&key.color)?;
        let prefilter = match &key.prefilter {
            Some([albedo, normal]) => Some([denoiser(albedo)?, denoiser(normal)?]),
            None => None,
        };
        Ok(Self { color, prefilter })
    }

    /// Prefilters albedo and normals; returns `None`s unless the settings ask for it.
    ///
    /// # Errors
    /// The engine's error.
    pub(crate) fn prefiltered(&self, frame: &Frame<'_>) -> Result<[Option<Image>; 2], Error> {
        let Some([albedo, normal]) = &self.prefilter else { return Ok([None, None]) };
        let clean = |denoiser: &Denoiser, image: Option<&Image>| {
            let alone = |image| Frame::new(image).stop(frame.stop);
            let denoised = |image| denoiser.denoise_layers(&alone(image), &mut |_| {});
            image.map(|image| Ok(denoised(image)?.color)).transpose()
        };
        Ok([clean(albedo, frame.albedo)?, clean(normal, frame.normal)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_the_weights_that_fit_and_prefiltering_needs_both_images() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["rt_hdr.tza", "rt_hdr_calb_cnrm.tza", "rt_alb.tza", "rt_nrm.tza"] {
            std::fs::write(folder.path().join(name), name).unwrap();
        }
        let weights = Source::of(folder.path());
        let settings = Settings { weights, ..Settings::default() };
        let key = |settings: &Settings, inputs| Key::of(settings, inputs, true);
        let chosen = key(&settings, Inputs::ALL).unwrap();
        assert_eq!(chosen.notice(&settings).unwrap(), "weights: rt_hdr.tza");
        let settings = Settings { prefilter: true, ..settings };
        let chosen = key(&settings, Inputs::ALL).unwrap();
        assert_eq!(chosen.notice(&settings).unwrap(), "weights: rt_hdr_calb_cnrm.tza");
        assert!(chosen.prefilter.is_some());
        let albedo = Inputs { albedo: true, normal: false };
        assert!(key(&settings, albedo).unwrap_err().starts_with("prefiltering needs"));
        let display = Key::of(&settings, Inputs::ALL, false).unwrap_err();
        assert!(display.contains("rt_ldr_calb_cnrm.tza"), "{display}");
    }

    #[test]
    fn a_rewritten_file_makes_another_network() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.safetensors");
        std::fs::write(&path, "short").unwrap();
        let settings = Settings { weights: Source::of(&path), ..Settings::default() };
        let before = Key::of(&settings, Inputs::ALL, true).unwrap();
        assert_eq!(Key::of(&settings, Inputs::ALL, true).unwrap(), before);
        std::fs::write(&path, "longer").unwrap();
        assert_ne!(Key::of(&settings, Inputs::ALL, true).unwrap(), before);
        assert!(before.color.load().unwrap_err().contains("is not a weights file"));
    }
}
