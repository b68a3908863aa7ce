//! `--prefilter`: albedo and normal without noise, before they help to denoise the colour.

use clap::Args;

use super::args::EngineArgs;
use super::failure::Failure;
use super::weights::{self, Given};
use wgdenoise::MainImage;
use wgdenoise::{Denoiser, Frame, Gpu, Image, Inputs, Options, Weights};

/// Whether to do so.
#[derive(Debug, Args)]
pub(super) struct PrefilterArgs {
    /// Denoise albedo and normal first, by Open Image Denoise's weights in the folder that
    /// --weights names
    #[arg(long, requires = "weights", conflicts_with = "no_aux")]
    prefilter: bool,
}

impl PrefilterArgs {
    /// Refuses `--prefilter` with anything but a folder of weights.
    pub(super) fn check(&self, args: &EngineArgs) -> Result<(), Failure> {
        match &args.weights {
            Some(path) if self.prefilter && !path.is_dir() => Err(Failure::Usage(format!(
                "--prefilter needs a folder with the weights for albedo and normal, but --weights \
                 names {}, which is none; name the folder",
                path.display()
            ))),
            _ => Ok(()),
        }
    }

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

    /// The weights that do it, for albedo and for normals, from the folder of `--weights`.
    pub(super) fn weights(&self, args: &EngineArgs) -> Result<Option<[Weights; 2]>, Failure> {
        let Some(folder) = args.weights.as_deref().filter(|_| self.prefilter) else {
            return Ok(None);
        };
        let load = |main: MainImage| {
            let given = Given { main, inputs: Inputs::default(), ..Given::ALL };
            weights::load(&weights::choose(folder, given, args.quality)?)
        };
        Ok(Some([load(MainImage::Albedo)?, load(MainImage::Normal)?]))
    }
}

/// A denoiser for albedo and one for normals.
pub(super) struct Prefilter([Denoiser; 2]);

impl Prefilter {
    /// With the weights for albedo and those for normals.
    pub(super) fn new(
        [albedo, normal]: &[Weights; 2],
        gpu: &Gpu,
        options: &Options,
    ) -> Result<Self, Failure> {
        let denoiser = |weights| Denoiser::new(&gpu.device, &gpu.queue, weights, options);
        Ok(Self([denoiser(albedo)?, denoiser(normal)?]))
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
            let frame = |color| Frame::new(color);
            image.map(|image| denoise(denoiser, &frame(image))).transpose()
        };
        Ok([alone(albedo, frame.albedo)?, alone(normal, frame.normal)?])
    }
}
