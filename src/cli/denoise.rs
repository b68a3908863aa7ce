//! `wgdenoise IN... OUT`.

use std::cell::RefCell;
use std::collections::HashSet;
use std::time::Instant;

use super::args::DenoiseArgs;
use super::budget;
use super::failure::Failure;
use super::jobs::{self, Job};
use super::pipelines;
use super::prefilter::Prefilter;
use super::progress::Progress;
use super::say;
use super::weights::{Given, Source};
use crate::files::Picture;
use crate::model::{Main, TransferFunction};
use crate::{Denoiser, Frame, Gpu, Image, Options};

/// Reads, denoises and writes, picture by picture.
pub(super) fn run(args: &DenoiseArgs) -> Result<(), Failure> {
    let jobs = jobs::plan(args)?;
    let mut work = Work::new(args, jobs.len());
    for job in &jobs {
        work.picture(job)?;
    }
    work.finish()
}

/// The denoiser of all pictures, and what is said of them.
struct Work<'a> {
    args: &'a DenoiseArgs,
    engine: Option<Engine>,
    pictures: usize,
    failed: usize,
    watch: Stopwatch,
    said: RefCell<HashSet<String>>,
}

/// A denoiser, and what it was made of.
struct Engine {
    gpu: Gpu,
    options: Options,
    /// `None` if the budget has chosen.
    weights: Option<Source>,
    denoiser: Denoiser,
    prefilter: Option<Prefilter>,
}

impl<'a> Work<'a> {
    fn new(args: &'a DenoiseArgs, pictures: usize) -> Self {
        let watch = Stopwatch { last: Instant::now(), laps: Vec::new() };
        Self { args, engine: None, pictures, failed: 0, watch, said: RefCell::default() }
    }

    /// Of several pictures, one that fails is told of and the others go on, unless the device failed.
    ///
    /// # Errors
    /// If the only picture fails, or there can be no denoiser.
    fn picture(&mut self, job: &Job) -> Result<(), Failure> {
        let outcome = match self.read(job) {
            Ok((picture, weights)) => {
                let engine = self.engine(job, &picture, weights)?;
                self.denoise_and_write(job, &picture, engine)
            }
            Err(failure) => Err(failure),
        };
        match outcome {
            Err(failure) if self.pictures > 1 && !matches!(failure, Failure::Device(_)) => {
                say(&format!("error: {failure}"));
                self.failed += 1;
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// The picture, and which weights it needs.
    fn read(&mut self, job: &Job) -> Result<(Picture, Option<Source>), Failure> {
        let picture = Picture::open(&job.input, &job.layers)?;
        self.notices(job, picture.notices());
        let weights = self.args.source(&picture)?;
        self.watch.lap("read");
        Ok((picture, weights))
    }

    /// The denoiser, made for the first picture, and anew for one that needs other weights.
    fn engine(
        &mut self,
        job: &Job,
        picture: &Picture,
        weights: Option<Source>,
    ) -> Result<Engine, Failure> {
        let before = match self.engine.take() {
            Some(engine) if engine.weights == weights => return Ok(engine),
            engine => engine.map(|Engine { gpu, options, .. }| (gpu, options)),
        };
        let engine = self.args.engine(&self.args.frame(picture), weights, before)?;
        let Engine { gpu, denoiser, .. } = &engine;
        self.args.details(|| adapter_and_kernels(gpu, denoiser));
        self.notices(job, &engine.notices());
        self.watch.lap("prepared");
        Ok(engine)
    }

    fn denoise_and_write(
        &mut self,
        job: &Job,
        picture: &Picture,
        engine: Engine,
    ) -> Result<(), Failure> {
        let frame = self.args.frame(picture);
        let unusable = unusable_pixels(frame.color, &engine.denoiser);
        self.args.notices(&unusable.iter().map(|n| self.about(job, n)).collect::<Vec<_>>());
        self.notices(job, &unread_inputs(&engine.denoiser, &frame));
        let result = engine.denoise(self.args, &frame);
        self.engine = Some(engine);
        let result = result?;
        self.watch.lap("denoised");
        let notices = picture.save(&job.output, &result, self.args.force)?;
        self.notices(job, &notices);
        self.watch.lap("written");
        let laps = self.watch.told();
        self.args.details(|| self.about(job, &laps));
        Ok(())
    }

    /// Says what has not been said yet, of several pictures with the name.
    fn notices(&self, job: &Job, notices: &[String]) {
        for notice in notices {
            if self.said.borrow_mut().insert(notice.clone()) {
                self.args.notices(&[self.about(job, notice)]);
            }
        }
    }

    fn about(&self, job: &Job, text: &str) -> String {
        match self.pictures {
            1 => text.into(),
            _ => format!("{}: {text}", job.input.display()),
        }
    }

    /// Keeps what the driver compiled and sums up.
    fn finish(self) -> Result<(), Failure> {
        if let Some(Engine { gpu, options, .. }) = &self.engine {
            pipelines::keep(gpu, options);
        }
        match (self.pictures, self.failed) {
            (1, _) => {}
            (all, 0) => self.args.notices(&[format!("all {all} pictures denoised")]),
            (all, failed) => {
                return Err(Failure::Work(format!("{failed} of {all} pictures failed")));
            }
        }
        Ok(())
    }
}

impl Engine {
    /// What a user should know of the choices.
    fn notices(&self) -> Vec<String> {
        let weights = self.weights.as_ref().and_then(Source::notice);
        let prefilter = self.prefilter.as_ref().map(Prefilter::notice);
        weights.into_iter().chain(prefilter).chain(self.denoiser.notices()).collect()
    }

    fn denoise(&self, args: &DenoiseArgs, frame: &Frame<'_>) -> Result<Image, Failure> {
        let Some(prefilter) = &self.prefilter else { return args.denoise(&self.denoiser, frame) };
        let clean = prefilter.images(frame, |denoiser, frame| args.denoise(denoiser, frame))?;
        let [albedo, normal] = clean.each_ref().map(Option::as_ref);
        args.denoise(&self.denoiser, &Frame { albedo, normal, ..*frame })
    }
}

impl DenoiseArgs {
    fn frame<'a>(&self, picture: &'a Picture) -> Frame<'a> {
        Frame {
            color: picture.color(),
            albedo: picture.albedo(),
            normal: picture.normal(),
            input_scale: self.input_scale,
        }
    }

    /// Which weights the picture needs; `None` if the budget chooses.
    fn source(&self, picture: &Picture) -> Result<Option<Source>, Failure> {
        if self.budget.limit().is_some() {
            return Ok(None);
        }
        let inputs = self.frame(picture).inputs();
        let (hdr, clean) = (!picture.is_display_referred(), self.prefilter.applies(inputs)?);
        self.engine.source(Given { main: Main::Color, inputs, hdr, clean }).map(Some)
    }

    /// On the adapter that there was before or else that of the flags.
    fn engine(
        &self,
        frame: &Frame<'_>,
        weights: Option<Source>,
        before: Option<(Gpu, Options)>,
    ) -> Result<Engine, Failure> {
        // Files first: an adapter takes longer to open.
        let loaded = weights.as_ref().map(Source::load).transpose()?;
        let (gpu, options) = before.map_or_else(|| self.engine.open(), Ok)?;
        let denoiser = match &loaded {
            Some(weights) => Denoiser::new(&gpu.device, &gpu.queue, weights, &options)?,
            None => self.within_budget(&gpu, &options, frame)?,
        };
        let prefilter = self.prefilter.denoisers(&self.engine, &gpu, &options)?;
        Ok(Engine { gpu, options, weights, denoiser, prefilter })
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
        let result = denoiser.denoise(frame, &mut |done, of| progress.set(done, of));
        drop(progress);
        self.notices(&denoiser.notices());
        let result = result?;
        if self.verify {
            let verified = denoiser.verify(frame, &result)?;
            self.details(|| {
                verified.map_or(NOTHING_VERIFIED.into(), |verified| verified.to_string())
            });
        }
        Ok(result)
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

const NOTHING_VERIFIED: &str = "nothing to verify: the picture has no noise";

/// Says how many pixels hold no light that can be denoised.
fn unusable_pixels(color: &Image, denoiser: &Denoiser) -> Vec<String> {
    let signed = denoiser.weights().metadata().transfer_function == TransferFunction::Signed;
    let count = |is_bad: fn(&[f32; 3]) -> bool| color.pixels().iter().filter(|p| is_bad(p)).count();
    let bad = count(|pixel| pixel.iter().any(|v| !v.is_finite()));
    let negative = count(|pixel| pixel.iter().any(|&v| v.is_finite() && v < 0.0));
    let negative = if signed { 0 } else { negative };
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let filled = format!("{} NaN or infinite and filled from good ones beside them", pixels(bad));
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

struct Stopwatch {
    last: Instant,
    laps: Vec<String>,
}

impl Stopwatch {
    /// Notes the time since the last call.
    fn lap(&mut self, what: &str) {
        let now = Instant::now();
        let lap = now.duration_since(std::mem::replace(&mut self.last, now));
        self.laps.push(format!("{what} in {lap:.1?}"));
    }

    /// All notes, which begin anew.
    fn told(&mut self) -> String {
        std::mem::take(&mut self.laps).join(", ")
    }
}
