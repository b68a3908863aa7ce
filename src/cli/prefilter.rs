//! `--prefilter`: albedo and normal without noise, before they help to denoise the colour.

use clap::Args;

use super::args::EngineArgs;
use super::failure::Failure;
use super::weights::{self, Given};
use crate::model::Main;
use crate::{Denoiser, Frame, Gpu, Image, Inputs, Options};

/// Whether to do so.
#[derive(Debug, Args)]
pub(super) struct PrefilterArgs {
    /// Denoise albedo and normal first, by Open Image Denoise's weights in the folder of --weights
    #[arg(long, requires = "weights", conflicts_with = "no_aux")]
    prefilter: bool,
}

impl PrefilterArgs {
    /// Whether it is wanted of a picture with these inputs.
    ///
    /// # Errors
    /// If it is, but there is nothing to denoise first.
    pub(super) fn applies(&self, inputs: Inputs) -> Result<bool, Failure> {
        if self.prefilter && inputs != Inputs::ALL {
            return Err(Failure::Work(format!(
                "--prefilter needs albedo and normal, but the picture has {inputs}; leave it out"
            )));
        }
        Ok(self.prefilter)
    }

    /// What does it, with the weights in the folder of `--weights`.
    pub(super) fn denoisers(
        &self,
        args: &EngineArgs,
        gpu: &Gpu,
        options: &Options,
    ) -> Result<Option<Prefilter>, Failure> {
        self.prefilter.then(|| Prefilter::new(args, gpu, options)).transpose()
    }
}

/// A denoiser for albedo and one for normals.
pub(super) struct Prefilter([Denoiser; 2]);

impl Prefilter {
    fn new(args: &EngineArgs, gpu: &Gpu, options: &Options) -> Result<Self, Failure> {
        let folder = args.weights_folder().ok_or_else(|| {
            Failure::Usage("--prefilter needs a folder of weights; give one by --weights".into())
        })?;
        let denoiser = |main: Main| -> Result<Denoiser, Failure> {
            let given = Given { main, inputs: Inputs::default(), ..Given::ALL };
            let weights = weights::load(&weights::choose(&folder, given, args.quality)?)?;
            Ok(Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?)
        };
        Ok(Self([denoiser(Main::Albedo)?, denoiser(Main::Normal)?]))
    }

    /// Which weights they have.
    pub(super) fn notice(&self) -> String {
        let names = self.0.each_ref().map(|denoiser| denoiser.weights().metadata().name.as_str());
        format!("albedo and normal denoised first, by {}", names.join(" and "))
    }

    /// The frame's albedo and normal without noise.
    pub(super) fn images(
        &self,
        frame: &Frame<'_>,
        denoise: impl Fn(&Denoiser, &Frame<'_>) -> Result<Image, Failure>,
    ) -> Result<[Option<Image>; 2], Failure> {
        let [albedo, normal] = &self.0;
        let alone = |denoiser, image: Option<&Image>| {
            let frame = |color| Frame { color, albedo: None, normal: None, input_scale: None };
            image.map(|image| denoise(denoiser, &frame(image))).transpose()
        };
        Ok([alone(albedo, frame.albedo)?, alone(normal, frame.normal)?])
    }
}
