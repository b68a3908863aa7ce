//! `wgdenoise IN... OUT`: reads, denoises and writes, image by image.

use std::time::{Duration, Instant};

use crate::console::{Console, Verbosity};
use crate::failure::{Failure, shown};
use crate::fit;
use crate::plan::{self, Job};
use crate::request::Denoise;
use crate::session::{Networks, Session};
use wgdenoise::Frame;
use wgdenoise_files::{Denoised, Format, Picture, Selection, View, escaped, exposed};

/// Carries out a request.
pub(crate) fn run(request: &Denoise, console: &Console) -> Result<(), Failure> {
    let jobs = plan::jobs(request)?;
    let session = Session::new(&request.device, &request.weights, console)?;
    let mut batch = Batch {
        request,
        console,
        session,
        images: jobs.len(),
        failed: 0,
        watch: Stopwatch::start(),
    };
    console.begin(jobs.len());
    let outcome = jobs.iter().enumerate().try_for_each(|(i, job)| batch.image(i, job));
    console.end();
    outcome?;
    batch.finish(&jobs)
}

/// The images of one run.
struct Batch<'a> {
    request: &'a Denoise,
    console: &'a Console,
    session: Session<'a>,
    images: usize,
    failed: usize,
    watch: Stopwatch,
}

impl Batch<'_> {
    /// Denoises one image. One of several that fails is reported, and the batch continues.
    ///
    /// # Errors
    /// If the only image fails, there is no adapter, or the device failed.
    fn image(&mut self, index: usize, job: &Job) -> Result<(), Failure> {
        self.console.item(index, &name(job));
        let outcome = match self.read(job) {
            Ok((picture, networks)) => {
                self.session.open()?;
                self.denoise_and_write(job, &picture, networks)
            }
            Err(failure) => Err(failure),
        };
        match outcome {
            Err(Failure::Work(what)) if self.images > 1 => {
                self.failed += 1;
                self.console.error(&Failure::Work(self.with_name(job, what)));
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// The image, and the weights that it needs unless the session has them.
    fn read(&mut self, job: &Job) -> Result<(Picture, Option<Networks>), Failure> {
        let picture = Picture::open(&job.input, &job.layers)?;
        for selection in picture.views().iter().filter_map(View::selection) {
            self.tell_selection(job, selection);
        }
        self.tell(job, picture.notices());
        let inputs = self.frame(picture.first()).inputs();
        let networks = self.session.networks(inputs, !picture.is_display_referred())?;
        self.watch.lap("read");
        Ok((picture, networks))
    }

    fn frame<'p>(&self, view: &'p View) -> Frame<'p> {
        Frame::new(view.color())
            .albedo(view.albedo())
            .normal(view.normal())
            .input_scale(self.request.input_scale)
            .panorama(view.is_panorama())
    }

    fn denoise_and_write(
        &mut self,
        job: &Job,
        picture: &Picture,
        networks: Option<Networks>,
    ) -> Result<(), Failure> {
        let frame = self.frame(picture.first());
        if let Some(networks) = networks {
            let notices = self.session.prepare(networks, &frame)?;
            self.tell(job, &notices);
            self.watch.lap("prepared");
        }
        let (metadata, named) = (self.session.metadata(), self.session.weights_are_named());
        fit::check(metadata, job, picture)?;
        for notice in picture.views().iter().flat_map(|v| fit::unusable_pixels(metadata, v.color()))
        {
            self.console.notice(&format!("{}{notice}", self.about(job)));
        }
        self.tell(job, &fit::notices(metadata, named, picture));
        let mut results = Vec::new();
        for view in picture.views() {
            let mut color = self.session.denoise(&self.frame(view), self.request.verify)?;
            if Format::of_extension(&job.output).is_ok_and(Format::is_display_referred) {
                color = exposed(color, self.request.exposure.unwrap_or(0.0));
            }
            results.push(Denoised::from(color));
        }
        self.watch.lap("denoised");
        let notices = picture.save(&job.output, &results, job.replace)?;
        self.tell(job, &notices);
        self.watch.lap("written");
        let laps = self.watch.laps();
        self.console.detail(|| self.about(job) + &laps);
        Ok(())
    }

    /// One line on the layers that are used; with `--verbose`, each with the reason.
    fn tell_selection(&self, job: &Job, selection: &Selection) {
        match self.console.verbosity {
            Verbosity::Verbose => self.tell(job, &selection.explanation),
            _ => self.tell(job, &[selection.summary(LINE_WIDTH)]),
        }
        let others: Vec<_> = other_colors(selection).into_iter().collect();
        self.tell(job, &others);
    }

    /// Tells what a user should know, each sentence once per run.
    fn tell(&self, job: &Job, notices: &[String]) {
        let about = self.about(job);
        for notice in notices {
            self.console.notice_once(&about, notice);
        }
    }

    /// The start of a message on one of several images.
    fn about(&self, job: &Job) -> String {
        if self.images == 1 { String::new() } else { format!("{}: ", shown(&job.input)) }
    }

    /// A message with the image's name, unless it starts with it.
    fn with_name(&self, job: &Job, what: String) -> String {
        let about = self.about(job);
        if what.starts_with(&about) { what } else { about + &what }
    }

    /// Closes the session and sums up.
    fn finish(self, jobs: &[Job]) -> Result<(), Failure> {
        self.session.close();
        let time = seconds(self.watch.total());
        let (all, failed) = (self.images, self.failed);
        if failed < all {
            self.console.notice(&match (jobs, failed) {
                ([job], _) => format!("wrote {} in {time}", shown(&job.output)),
                (_, 0) => format!("wrote {all} images in {time}"),
                _ => format!("wrote {} of {all} images in {time}", all - failed),
            });
        }
        match failed {
            0 => Ok(()),
            _ => Err(Failure::Work(format!("{failed} of {all} images failed"))),
        }
    }
}

/// A line of a terminal with 80 columns, without the program's name.
const LINE_WIDTH: usize = 80 - "wgdenoise: ".len();

/// Tells that only one of several beauty layers is denoised.
pub(crate) fn other_colors(selection: &Selection) -> Option<String> {
    let named = |name: &String| format!("`{}`", escaped(name));
    let listed = selection.other_colors.iter().map(named).collect::<Vec<_>>().join(", ");
    match selection.other_colors.len() {
        0 => None,
        1 => Some(format!("{listed} stays as it is; name it with --color to denoise it")),
        _ => Some(format!("{listed} stay as they are; name one with --color to denoise it")),
    }
}

/// The file name of an input.
fn name(job: &Job) -> String {
    escaped(&job.input.file_name().unwrap_or_default().to_string_lossy())
}

/// `3.2 s`, or `4min 12s` for long runs.
fn seconds(time: Duration) -> String {
    if time < Duration::from_mins(1) {
        return format!("{:.1} s", time.as_secs_f64());
    }
    humantime::format_duration(Duration::from_secs(time.as_secs())).to_string()
}

struct Stopwatch {
    start: Instant,
    last: Instant,
    laps: Vec<String>,
}

impl Stopwatch {
    fn start() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, laps: Vec::new() }
    }

    /// Notes the time since the last call.
    fn lap(&mut self, what: &str) {
        let now = Instant::now();
        let lap = now.duration_since(std::mem::replace(&mut self.last, now));
        self.laps.push(format!("{what} in {lap:.1?}"));
    }

    /// All notes so far, which start over.
    fn laps(&mut self) -> String {
        std::mem::take(&mut self.laps).join(", ")
    }

    fn total(&self) -> Duration {
        self.start.elapsed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_as_people_write_them() {
        let text = |ms| seconds(Duration::from_millis(ms));
        assert_eq!((text(40).as_str(), text(3249).as_str()), ("0.0 s", "3.2 s"));
        assert_eq!((text(252_400).as_str(), text(3_600_000).as_str()), ("4m 12s", "1h"));
    }
}
