//! `wgdenoise IN... OUT`.

use std::cell::RefCell;
use std::collections::HashSet;
use std::time::Instant;

use super::args::DenoiseArgs;
use super::engine::{Engine, Networks};
use super::failure::Failure;
use super::jobs::{self, Job};
use super::{fit, pipelines, say};
use wgdenoise::{Frame, Gpu, Options, Weights};
use wgdenoise_files::Picture;

/// Reads, denoises and writes, picture by picture.
pub(super) fn run(args: &DenoiseArgs) -> Result<(), Failure> {
    args.engine.check()?;
    args.prefilter.check(&args.engine)?;
    let jobs = jobs::plan(args)?;
    let mut work = Work::new(args, jobs.len())?;
    for job in &jobs {
        work.picture(job)?;
    }
    work.finish()
}

/// What serves all pictures, and what is said of them.
struct Work<'a> {
    args: &'a DenoiseArgs,
    /// Of the file that the user named. All pictures need it, so it is read before them.
    named: Option<Weights>,
    device: Option<(Gpu, Options)>,
    engine: Option<Engine>,
    pictures: usize,
    failed: usize,
    watch: Stopwatch,
    said: RefCell<HashSet<String>>,
}

impl<'a> Work<'a> {
    fn new(args: &'a DenoiseArgs, pictures: usize) -> Result<Self, Failure> {
        let named = args.engine.named_weights()?;
        let watch = Stopwatch { last: Instant::now(), laps: Vec::new() };
        let (device, engine, said) = (None, None, RefCell::default());
        Ok(Self { args, named, device, engine, pictures, failed: 0, watch, said })
    }

    /// Of several pictures, one that fails is told of and the others go on.
    ///
    /// # Errors
    /// If the only picture fails, there is no adapter for the flags, or the device failed.
    fn picture(&mut self, job: &Job) -> Result<(), Failure> {
        let outcome = match self.read(job) {
            Ok((picture, networks)) => {
                self.open()?;
                self.denoise_and_write(job, &picture, networks)
            }
            Err(failure) => Err(failure),
        };
        match outcome {
            Err(Failure::Work(what)) if self.pictures > 1 => {
                self.failed += 1;
                say(&format!("error: {}", self.with_name(job, what)));
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// The picture, and the weights that it needs unless the engine has them. They come before the
    /// adapter, which takes longer.
    fn read(&mut self, job: &Job) -> Result<(Picture, Option<Networks>), Failure> {
        let picture = Picture::open(&job.input, &job.layers)?;
        self.notices(job, picture.notices());
        let source = self.args.source(&picture)?;
        let fits = self.engine.as_ref().is_some_and(|engine| engine.source == source);
        let load = || Networks::load(self.args, source, self.named.as_ref());
        let networks = (!fits).then(load).transpose()?;
        self.watch.lap("read");
        Ok((picture, networks))
    }

    /// The adapter of the flags, once for all pictures.
    fn open(&mut self) -> Result<(), Failure> {
        if self.device.is_none() {
            self.device = Some(self.args.engine.open()?);
        }
        Ok(())
    }

    fn denoise_and_write(
        &mut self,
        job: &Job,
        picture: &Picture,
        networks: Option<Networks>,
    ) -> Result<(), Failure> {
        let frame = self.args.frame(picture);
        if let Some(networks) = networks {
            self.prepare(job, &frame, networks)?;
        }
        let engine = self.engine.as_ref().expect("the engine fits or has just been made");
        fit::check(engine, job, picture)?;
        let unusable = fit::unusable_pixels(engine, frame.color);
        self.args.notices(&unusable.iter().map(|n| self.about(job, n)).collect::<Vec<_>>());
        self.notices(job, &fit::notices(engine, picture));
        let result = engine.denoise(self.args, &frame)?;
        self.watch.lap("denoised");
        let notices = picture.save(&job.output, &result, self.args.force)?;
        self.notices(job, &notices);
        self.watch.lap("written");
        let laps = self.watch.told();
        self.args.details(|| self.about(job, &laps));
        Ok(())
    }

    /// Makes the engine of these networks, in place of the one before.
    fn prepare(&mut self, job: &Job, frame: &Frame<'_>, networks: Networks) -> Result<(), Failure> {
        // Its memory may be needed.
        self.engine = None;
        let (gpu, options) = self.device.as_ref().expect("it is open");
        let engine = Engine::new(self.args, gpu, options, networks, frame)?;
        self.args.details(|| engine.adapter_and_kernels(gpu));
        self.notices(job, &engine.notices());
        self.engine = Some(engine);
        self.watch.lap("prepared");
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

    /// What went wrong, with the picture's name if it does not begin with it.
    fn with_name(&self, job: &Job, what: String) -> String {
        let begin = format!("{}: ", job.input.display());
        if what.starts_with(&begin) { what } else { self.about(job, &what) }
    }

    /// Keeps what the driver compiled and sums up.
    fn finish(self) -> Result<(), Failure> {
        if let Some((gpu, options)) = &self.device {
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

impl DenoiseArgs {
    pub(super) fn frame<'a>(&self, picture: &'a Picture) -> Frame<'a> {
        Frame::new(picture.color())
            .albedo(picture.albedo())
            .normal(picture.normal())
            .input_scale(self.input_scale)
    }

    /// What a user should know, one line each.
    pub(super) fn notices(&self, notices: &[String]) {
        if !self.quiet {
            for notice in notices {
                say(notice);
            }
        }
    }

    /// What only `--verbose` tells.
    pub(super) fn details(&self, text: impl FnOnce() -> String) {
        if self.verbose {
            say(&text());
        }
    }
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
