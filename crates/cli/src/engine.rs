//! What denoises a picture: a network for the colour and, if asked for, two for albedo and normal
//! before it.

use super::args::DenoiseArgs;
use super::budget;
use super::failure::Failure;
use super::prefilter::Prefilter;
use super::progress::Progress;
use super::weights::{Given, Source};
use wgdenoise::{Denoiser, Frame, Gpu, Image, Options, Weights};
use wgdenoise::{MainImage, Metadata};
use wgdenoise_files::Picture;

/// All weights of an engine, read from their files.
pub(super) struct Networks {
    /// `None` if the budget chooses.
    color: Option<(Source, Weights)>,
    /// Those for albedo and normal.
    prefilter: Option<[Weights; 2]>,
}

impl Networks {
    /// Those that the source tells; `named` are those of the file that the user named.
    pub(super) fn load(
        args: &DenoiseArgs,
        source: Option<Source>,
        named: Option<&Weights>,
    ) -> Result<Self, Failure> {
        let load = |source: Source| {
            let weights = named.map_or_else(|| source.load(), |weights| Ok(weights.clone()))?;
            Ok::<_, Failure>((source, weights))
        };
        let color = source.map(load).transpose()?;
        Ok(Self { color, prefilter: args.prefilter.weights(&args.engine)? })
    }
}

/// Denoisers, and where their weights come from.
pub(super) struct Engine {
    /// `None` if the budget has chosen.
    pub(super) source: Option<Source>,
    denoiser: Denoiser,
    prefilter: Option<Prefilter>,
}

impl Engine {
    /// The frame is what the budget looks at.
    pub(super) fn new(
        args: &DenoiseArgs,
        gpu: &Gpu,
        options: &Options,
        networks: Networks,
        frame: &Frame<'_>,
    ) -> Result<Self, Failure> {
        let (source, denoiser) = match networks.color {
            Some((source, weights)) => {
                (Some(source), Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?)
            }
            None => (None, args.within_budget(gpu, options, frame)?),
        };
        let prefilter = networks.prefilter.map(|weights| Prefilter::new(&weights, gpu, options));
        Ok(Self { source, denoiser, prefilter: prefilter.transpose()? })
    }

    /// What the weights for the colour say of themselves.
    pub(super) fn metadata(&self) -> &Metadata {
        self.denoiser.weights().metadata()
    }

    /// What a user should know of the choices.
    pub(super) fn notices(&self) -> Vec<String> {
        let weights = self.source.as_ref().and_then(Source::notice);
        let prefilter = self.prefilter.as_ref().map(Prefilter::notice);
        weights.into_iter().chain(prefilter).chain(self.denoiser.take_notices()).collect()
    }

    pub(super) fn adapter_and_kernels(&self, gpu: &Gpu) -> String {
        let (kernels, precision) = (self.denoiser.kernels(), self.denoiser.precision());
        format!(
            "on {} ({:?}, {:?}), kernels {kernels}, tensors in {precision:?}",
            gpu.info.name, gpu.info.backend, gpu.info.device_type
        )
    }

    pub(super) fn denoise(&self, args: &DenoiseArgs, frame: &Frame<'_>) -> Result<Image, Failure> {
        let Some(prefilter) = &self.prefilter else { return args.denoise(&self.denoiser, frame) };
        let clean = prefilter.images(frame, |denoiser, frame| args.denoise(denoiser, frame))?;
        let [albedo, normal] = clean.each_ref().map(Option::as_ref);
        args.denoise(&self.denoiser, &frame.albedo(albedo).normal(normal))
    }
}

impl DenoiseArgs {
    /// Which weights the picture needs; `None` if the budget chooses.
    pub(super) fn source(&self, picture: &Picture) -> Result<Option<Source>, Failure> {
        if self.budget.limit().is_some() {
            return Ok(None);
        }
        let inputs = self.frame(picture).inputs();
        let (hdr, clean) = (!picture.is_display_referred(), self.prefilter.applies(inputs)?);
        self.engine.source(Given { main: MainImage::Color, inputs, hdr, clean }).map(Some)
    }

    /// With the weights that the budget allows.
    fn within_budget(
        &self,
        gpu: &Gpu,
        options: &Options,
        frame: &Frame<'_>,
    ) -> Result<Denoiser, Failure> {
        let limit = self.budget.limit().expect("there is a budget where no weights are named");
        let anew = self.budget.recalibrate;
        let kept = budget::calibration(gpu, options, anew, |text| self.notices(&[text]))?;
        let (denoiser, chosen) = budget::choose(&kept, limit, gpu, options, frame)?;
        self.notices(&[chosen]);
        Ok(denoiser)
    }

    fn denoise(&self, denoiser: &Denoiser, frame: &Frame<'_>) -> Result<Image, Failure> {
        let (width, height) = frame.color.size();
        let inputs = frame.inputs().intersection(denoiser.weights().metadata().inputs);
        let plan = denoiser.tile_plan(width, height, inputs)?;
        let memory = denoiser.memory_bytes(width, height, inputs)?;
        self.details(|| {
            let (count, [w, h]) = (plan.tiles.len(), plan.tile);
            format!(
                "{width}×{height} pixels in {count} tile{} of {w}×{h}, {} MiB of GPU memory",
                if count == 1 { "" } else { "s" },
                memory.div_ceil(1 << 20)
            )
        });
        let progress = Progress::new(plan.tiles.len(), "tiles", self.quiet);
        let result = denoiser.denoise_with_progress(frame, &mut |done, of| progress.set(done, of));
        drop(progress);
        self.notices(&denoiser.take_notices());
        let result = result?;
        if self.verify {
            let verified = denoiser.verify(frame, &result)?;
            self.details(|| {
                verified.map_or(NOTHING_VERIFIED.into(), |verified| verified.to_string())
            });
        }
        Ok(result)
    }
}

const NOTHING_VERIFIED: &str = "nothing to verify: the picture has no noise";
