//! `--prefilter`: albedo and normal without noise, before they help to denoise the colour.

use clap::Args;

use super::args::EngineArgs;
use super::failure::Failure;
use super::weights::{self, Given};
use crate::model::Main;
use crate::{Denoiser, Frame, Image, Inputs};

/// Whether to do so.
#[derive(Debug, Args)]
pub(super) struct PrefilterArgs {
    /// Denoise albedo and normal first, by Open Image Denoise's weights in the folder of --weights
    #[arg(long, requires = "weights", conflicts_with = "no_aux")]
    pub(super) prefilter: bool,
}

/// Both images, each denoised by the weights for it in the folder of `--weights`, and a line that
/// says which.
pub(super) fn prefilter(
    args: &EngineArgs,
    frame: &Frame<'_>,
) -> Result<([Image; 2], String), Failure> {
    let (Some(albedo), Some(normal)) = (frame.albedo, frame.normal) else {
        return Err(Failure::Work(format!(
            "--prefilter needs albedo and normal, but the picture has {}; leave it out",
            frame.inputs()
        )));
    };
    let folder = args.weights_folder().ok_or_else(|| {
        Failure::Usage("--prefilter needs a folder of weights; give one by --weights".into())
    })?;
    let gpu = args.open_gpu()?;
    let options = args.options(&gpu)?;
    let mut names = Vec::new();
    let mut denoise = |main: Main, image: &Image| -> Result<Image, Failure> {
        let given = Given { main, inputs: Inputs::default(), ..Given::ALL };
        let path = weights::choose(&folder, given, args.quality)?;
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights::load(&path)?, &options)?;
        names.push(weights::stem(&path));
        let frame = Frame { color: image, albedo: None, normal: None, input_scale: None };
        Ok(denoiser.denoise(&frame, &mut |_, _| {})?)
    };
    let images = [denoise(Main::Albedo, albedo)?, denoise(Main::Normal, normal)?];
    Ok((images, format!("albedo and normal denoised first, by {}", names.join(" and "))))
}
