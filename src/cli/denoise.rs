//! `wgdenoise IN OUT`.

use std::time::{Duration, Instant};

use super::args::DenoiseArgs;
use super::budget;
use super::failure::Failure;
use super::pipelines;
use super::prefilter::prefilter;
use super::progress::Progress;
use super::say;
use super::weights::Given;
use crate::files::{self, LayerChoice, Picture};
use crate::model::{Main, TransferFunction};
use crate::{Denoiser, Frame, Gpu, Image};

/// Reads, denoises and writes.
pub(super) fn run(args: &DenoiseArgs) -> Result<(), Failure> {
    let mut watch = Stopwatch(Instant::now());
    let usage = || Failure::Usage("give IN and OUT, or a command; see --help".into());
    let (input, output) = args.files().ok_or_else(usage)?;
    files::check_output(output, args.force)?;
    let picture = Picture::open(input, &LayerChoice::from(&args.layers))?;
    args.notices(picture.notices());
    let frame = Frame {
        color: picture.color(),
        albedo: picture.albedo(),
        normal: picture.normal(),
        input_scale: args.input_scale,
    };
    let read = watch.lap();

    let auxiliary = args.prefiltered(&frame)?;
    let [albedo, normal] = auxiliary.each_ref().map(Option::as_ref);
    let frame = Frame { albedo: albedo.or(frame.albedo), normal: normal.or(frame.normal), ..frame };
    let (gpu, denoiser) = args.denoiser(&frame, !picture.is_display_referred())?;
    args.notices(&unusable_pixels(frame.color, &denoiser));
    args.details(|| adapter_and_kernels(&gpu, &denoiser));
    args.notices(denoiser.notices());
    args.notices(&unread_inputs(&denoiser, &frame));
    let prepared = watch.lap();

    let result = args.denoise(&denoiser, &frame)?;
    let worked = watch.lap();
    let notices = picture.save(output, &result, args.force)?;
    args.notices(&notices);
    let written = watch.lap();
    pipelines::keep(&gpu, &denoiser.options);
    args.details(|| {
        format!(
            "read in {read:.1?}, prepared in {prepared:.1?}, denoised in {worked:.1?}, \
             written in {written:.1?}"
        )
    });
    Ok(())
}

impl DenoiseArgs {
    /// Albedo and normal without noise, if that is wanted.
    fn prefiltered(&self, frame: &Frame<'_>) -> Result<[Option<Image>; 2], Failure> {
        if !self.prefilter.prefilter {
            return Ok([None, None]);
        }
        let (images, line) = prefilter(&self.engine, frame)?;
        self.notices(&[line]);
        Ok(images.map(Some))
    }

    /// On the adapter of the flags, with the weights of the flags or those that the budget allows.
    fn denoiser(&self, frame: &Frame<'_>, hdr: bool) -> Result<(Gpu, Denoiser), Failure> {
        let Some(limit) = self.budget.limit() else {
            let (main, inputs, clean) = (Main::Color, frame.inputs(), self.prefilter.prefilter);
            let given = Given { main, inputs, hdr, clean };
            let (gpu, denoiser, notices) = self.engine.denoiser(given)?;
            self.notices(&notices);
            return Ok((gpu, denoiser));
        };
        let gpu = self.engine.open_gpu()?;
        let options = self.engine.options(&gpu)?;
        let anew = self.budget.recalibrate;
        let kept = budget::calibration(&gpu, &options, anew, |text| self.notices(&[text]))?;
        let (denoiser, chosen) = budget::choose(&kept, limit, &gpu, &options, frame)?;
        self.notices(&[chosen]);
        Ok((gpu, denoiser))
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
        Ok(denoiser.denoise(frame, &mut |done, _| progress.set(done))?)
    }

    /// What a user should know, one line each.
    fn notices(&self, notices: &[String]) {
        if !self.quiet {
            for notice in notices {
                say(notice);
            }
        }
    }

    /// What only `--verbose` tells.
    fn details(&self, text: impl FnOnce() -> String) {
        if self.verbose {
            say(&text());
        }
    }
}

/// Says how many pixels hold no light that can be denoised.
fn unusable_pixels(color: &Image, denoiser: &Denoiser) -> Vec<String> {
    let signed = denoiser.weights().metadata().transfer_function == TransferFunction::Signed;
    let count = |is_bad: fn(&[f32; 3]) -> bool| color.pixels().iter().filter(|p| is_bad(p)).count();
    let bad = count(|pixel| pixel.iter().any(|v| !v.is_finite()));
    let negative = count(|pixel| pixel.iter().any(|&v| v.is_finite() && v < 0.0));
    let negative = if signed { 0 } else { negative };
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let filled = format!("{} NaN or infinite and filled from the neighbours", pixels(bad));
    let black = format!("{} negative; negative values count as 0", pixels(negative));
    [(bad, filled), (negative, black)].into_iter().filter(|(n, _)| *n > 0).map(|(_, s)| s).collect()
}

/// Says which images the weights cannot use.
fn unread_inputs(denoiser: &Denoiser, frame: &Frame<'_>) -> Vec<String> {
    let metadata = denoiser.weights().metadata();
    let given = frame.inputs();
    if given.intersection(metadata.inputs) == given {
        return Vec::new();
    }
    vec![format!("the weights `{}` read {} and nothing else", metadata.name, metadata.inputs)]
}

fn adapter_and_kernels(gpu: &Gpu, denoiser: &Denoiser) -> String {
    let (kernels, precision) = (denoiser.kernels(), denoiser.precision());
    format!(
        "on {} ({:?}, {:?}), kernels {kernels}, tensors in {precision:?}",
        gpu.info.name, gpu.info.backend, gpu.info.device_type
    )
}

struct Stopwatch(Instant);

impl Stopwatch {
    /// The time since it was started or last asked.
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now.duration_since(std::mem::replace(&mut self.0, now))
    }
}
