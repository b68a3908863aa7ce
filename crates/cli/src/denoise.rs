//! `wgdenoise IN... OUT`: reads, denoises and writes, image by image.
//!
//! While an image is denoised, the next one is read and the last one is written, each on its own
//! thread. At most three images are in memory, plus those that others still need for `--temporal`.
//! Messages keep the order of the images.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crate::console::{Console, Verbosity};
use crate::failure::{Failure, shown};
use crate::interrupt::{self, Tally};
use crate::plan::{self, Job, Plan};
use crate::request::{self, Denoise};
use crate::session::Session;
use crate::stages::{Laps, Read, Ready, Written, read, write};
use crate::temporal::{Animation, Held};
use wgdenoise::Frame;
use wgdenoise_files::{Denoised, Picture, Selection, View, escaped, fit};

/// Carries out a request. Signals end the process, unless a host passes a flag that stops the run.
pub(crate) fn run(
    request: &Denoise,
    console: &Console,
    stop: Option<&AtomicBool>,
) -> Result<(), Failure> {
    let Plan { jobs, skipped, notices } = plan::plan(request)?;
    for notice in &notices {
        console.notice(notice);
    }
    if jobs.is_empty() {
        console.notice(&format!("nothing to do: skipped {}", existing(skipped)));
        return Ok(());
    }
    let session = Session::new(&request.device, &request.weights, console)?;
    let images = jobs.iter().filter(|job| job.writes).count();
    let (failed, start) = (0, Instant::now());
    let tally = Tally::default();
    let mut batch = Batch {
        request,
        console,
        session,
        images,
        skipped,
        failed,
        stop,
        tally,
        start,
        overtaken: 0,
    };
    console.begin(jobs.len());
    if stop.is_none() {
        let rest = rest(request.writing);
        interrupt::watch(console.last_words(batch.tally.clone(), images, rest));
    }
    let outcome = batch.images(&jobs);
    console.end();
    outcome?;
    batch.finish(&jobs)
}

/// Says how to go on after a run was stopped, or that the remaining files are unchanged.
/// `--skip-existing` excludes both flags that replace files.
fn rest(writing: request::Writing) -> &'static str {
    if writing.force || writing.in_place {
        "the other files are unchanged"
    } else {
        "give --skip-existing to resume"
    }
}

/// Unpacks a finished frame of an animation; `None` if it is not to be written.
fn ready(frame: Held<(&Job, Laps)>) -> Option<(&Job, Ready)> {
    let Held { picture, results, tag, .. } = frame;
    let (job, laps) = tag?;
    Some((job, Ready { picture, results, laps }))
}

/// The images of one run.
struct Batch<'a> {
    request: &'a Denoise,
    console: &'a Console,
    session: Session<'a>,
    images: usize,
    /// Images skipped because they were done before.
    skipped: usize,
    failed: usize,
    stop: Option<&'a AtomicBool>,
    tally: Tally,
    start: Instant,
    /// Images that another run has written since this one was planned.
    overtaken: usize,
}

/// An image that is being written.
type Writing<'scope, 'job> = (&'job Job, ScopedJoinHandle<'scope, Result<Written, Failure>>);

impl Batch<'_> {
    /// Denoises all images. If one of several fails, reports it and continues the batch.
    ///
    /// # Errors
    /// If the only image fails, there is no adapter, or the device failed.
    fn images(&mut self, jobs: &[Job]) -> Result<(), Failure> {
        let overlap = self.request.overlap;
        let mut animation = Animation::new(self.request.temporal);
        thread::scope(|scope| {
            let read = |job| scope.spawn(move || read(job));
            let (mut next, mut writing) = (None, None);
            for (index, job) in jobs.iter().enumerate() {
                self.console.item(index, &name(job));
                let image = joined(next.take().unwrap_or_else(|| read(job)));
                next = jobs.get(index + 1).filter(|_| overlap).map(read);
                if self.request.temporal == 0 && self.is_overtaken(job) {
                    self.overtaken += 1;
                    continue;
                }
                let outcome = image.and_then(|image| self.denoise(job, image));
                self.settle(writing.take())?;
                let finished = self.finished(&mut animation, job, outcome)?;
                writing = self.write_all(scope, finished)?;
                if !overlap {
                    self.settle(writing.take())?;
                }
            }
            self.settle(writing)?;
            let rest = animation.finish(self.console).into_iter().filter_map(ready).collect();
            let writing = self.write_all(scope, rest)?;
            self.settle(writing)
        })
    }

    /// Writes images one after the other; returns while the last one is still being written.
    fn write_all<'scope, 'job: 'scope>(
        &mut self,
        scope: &'scope Scope<'scope, '_>,
        images: Vec<(&'job Job, Ready)>,
    ) -> Result<Option<Writing<'scope, 'job>>, Failure> {
        let (exposure, mut writing) = (self.request.exposure, None);
        for (job, image) in images {
            self.settle(writing.take())?;
            writing = Some((job, scope.spawn(move || write(job, image, exposure))));
            self.console.hold();
        }
        Ok(writing)
    }

    /// The images that can be written once this one is denoised: itself, unless later frames are to
    /// be averaged into it. Reports a failed image.
    fn finished<'j>(
        &mut self,
        animation: &mut Animation<(&'j Job, Laps)>,
        job: &'j Job,
        outcome: Result<Ready, Failure>,
    ) -> Result<Vec<(&'j Job, Ready)>, Failure> {
        let image = match outcome {
            Ok(image) => image,
            Err(failure) => return self.fail(job, failure).map(|()| Vec::new()),
        };
        let Some(number) = job.number.filter(|_| self.request.temporal > 0) else {
            return Ok(vec![(job, image)]);
        };
        let Ready { picture, results, laps } = image;
        let frame = Held { number, picture, results, tag: job.writes.then_some((job, laps)) };
        Ok(animation.push(frame, self.console).into_iter().filter_map(ready).collect())
    }

    /// Denoises an image that has been read.
    fn denoise(&mut self, job: &Job, image: Read) -> Result<Ready, Failure> {
        let Read { picture, mut laps } = image;
        laps.resume();
        self.tell_reading(job, &picture);
        let mut results = Vec::new();
        for view in picture.views() {
            self.prepare(job, view, !picture.is_display_referred(), &mut laps)?;
            self.tell_fit(job, &picture, view)?;
            results.push(self.denoise_view(job, view)?);
        }
        laps.lap("denoised");
        Ok(Ready { picture: Arc::new(picture), results, laps })
    }

    /// Denoises a view with its further layers and alpha.
    fn denoise_view(&self, job: &Job, view: &View) -> Result<Denoised, Failure> {
        let layers: Vec<_> = view.layers().iter().map(|layer| &layer.image).collect();
        let alpha = if self.denoises_alpha(job, view) { view.alpha() } else { None };
        let frame = self.frame(view).layers(&layers).alpha(alpha).stop(self.stop);
        let found = self.session.denoise(&frame, self.request.verify)?;
        Ok(Denoised { color: found.color, alpha: found.alpha, layers: found.layers })
    }

    /// Whether to denoise the alpha. Reports the default choice, and requests that cannot be met.
    fn denoises_alpha(&self, job: &Job, view: &View) -> bool {
        let wish = self.request.alpha.map(Into::into).unwrap_or_default();
        let (denoises, notice) = fit::alpha(wish, view, Some(job.format), self.session.metadata());
        self.tell(job, notice.map(Into::into).as_slice());
        denoises
    }

    fn frame<'p>(&self, view: &'p View) -> Frame<'p> {
        Frame::new(view.color())
            .albedo(view.albedo())
            .normal(view.normal())
            .input_scale(self.request.input_scale)
            .panorama(view.is_panorama())
    }

    /// Makes the denoiser that a view needs, unless the session has it.
    fn prepare(
        &mut self,
        job: &Job,
        view: &View,
        hdr: bool,
        laps: &mut Laps,
    ) -> Result<(), Failure> {
        let frame = self.frame(view);
        let networks = self.session.networks(frame.inputs(), hdr)?;
        self.session.open()?;
        if let Some(networks) = networks {
            let notices = self.session.prepare(networks, &frame)?;
            self.tell(job, &notices);
            laps.lap("prepared");
        }
        Ok(())
    }

    /// Waits for an image to be written and reports it before messages about later images.
    fn settle(&mut self, writing: Option<Writing<'_, '_>>) -> Result<(), Failure> {
        let Some((job, thread)) = writing else { return Ok(()) };
        let outcome = joined(thread);
        let later = self.console.release();
        match outcome {
            Ok(Written { notices, laps }) => {
                self.tally.add();
                self.tell(job, &notices);
                self.console.detail(|| self.about(job) + &laps.to_string());
            }
            Err(_) if self.is_overtaken(job) => self.overtaken += 1,
            Err(failure) => self.fail(job, failure)?,
        }
        self.console.say_all(&later);
        Ok(())
    }

    /// Whether another run with `--skip-existing` was faster with this image.
    fn is_overtaken(&self, job: &Job) -> bool {
        self.request.skip_existing && job.writes && job.output.is_file()
    }

    /// Reports the failure of one of several images.
    ///
    /// # Errors
    /// If it is the only one, or the others would fail too.
    fn fail(&mut self, job: &Job, failure: Failure) -> Result<(), Failure> {
        match failure {
            Failure::Work(what) if !job.writes => {
                let what = self.with_name(job, what);
                self.console
                    .notice(&format!("{what}; the frames around it are averaged without it"));
                Ok(())
            }
            Failure::Work(what) if self.images > 1 => {
                self.failed += 1;
                self.console.error(&Failure::Work(self.with_name(job, what)));
                Ok(())
            }
            failure => Err(failure),
        }
    }

    /// Prints which layers are used, and how the file was read.
    fn tell_reading(&self, job: &Job, picture: &Picture) {
        for selection in picture.views().iter().filter_map(View::selection) {
            self.tell_selection(job, selection);
        }
        self.tell(job, picture.notices());
    }

    /// Reports mismatches between a view and the weights.
    ///
    /// # Errors
    /// If the files cannot hold what the weights are for.
    fn tell_fit(&self, job: &Job, picture: &Picture, view: &View) -> Result<(), Failure> {
        let (metadata, named) = (self.session.metadata(), self.session.weights_are_named());
        fit::check(metadata, picture, &job.input, Some((&job.output, job.format)))?;
        for notice in fit::unusable_pixels(metadata, view.color()) {
            self.console.notice(&format!("{}{notice}", self.about(job)));
        }
        self.tell(job, &fit::notices(metadata, named, view, !picture.is_display_referred()));
        Ok(())
    }

    /// Prints one line on the layers used, or with `--verbose` each with the reason.
    fn tell_selection(&self, job: &Job, selection: &Selection) {
        match self.console.verbosity {
            Verbosity::Verbose => self.tell(job, &selection.explanation),
            _ => self.tell(job, &[selection.summary(LINE_WIDTH)]),
        }
        let others: Vec<_> = other_colors(selection).into_iter().collect();
        self.tell(job, &others);
    }

    /// Prints what a user should know, each sentence once per run.
    fn tell(&self, job: &Job, notices: &[String]) {
        let about = self.about(job);
        for notice in notices {
            self.console.notice_once(&about, notice);
        }
    }

    /// The start of a message about one of several images.
    fn about(&self, job: &Job) -> String {
        if self.images == 1 { String::new() } else { format!("{}: ", shown(&job.input)) }
    }

    /// Prefixes a message with the image's name, unless it is there already.
    fn with_name(&self, job: &Job, what: String) -> String {
        let about = self.about(job);
        if what.starts_with(&about) { what } else { about + &what }
    }

    /// Closes the session and sums up.
    fn finish(self, jobs: &[Job]) -> Result<(), Failure> {
        self.session.close();
        let time = seconds(self.start.elapsed());
        let (all, failed) = (self.images - self.overtaken, self.failed);
        let skipped = self.skipped + self.overtaken;
        if all == 0 {
            self.console.notice(&format!("skipped {}", existing(skipped)));
        }
        if failed < all {
            let written: Vec<_> = jobs.iter().filter(|job| job.writes).collect();
            let wrote = match (written.as_slice(), failed) {
                ([job], _) => format!("wrote {} in {time}", shown(&job.output)),
                (_, 0) => format!("wrote {all} images in {time}"),
                _ => format!("wrote {} of {all} images in {time}", all - failed),
            };
            let skipped = match skipped {
                0 => String::new(),
                skipped => format!("; skipped {}", existing(skipped)),
            };
            self.console.notice(&(wrote + &skipped));
        }
        match failed {
            0 => Ok(()),
            _ => Err(Failure::Work(format!("{failed} of {all} images failed"))),
        }
    }
}

/// The width of an 80-column terminal, without the program's name.
const LINE_WIDTH: usize = 80 - "wgdenoise: ".len();

/// Says that only one of several beauty layers is denoised.
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

/// Counts the images that `--skip-existing` leaves out, in words.
fn existing(count: usize) -> String {
    match count {
        1 => "1 image whose output exists".into(),
        _ => format!("{count} images whose outputs exist"),
    }
}

/// Formats a time: `3.2 s`, or `4min 12s` for long runs.
fn seconds(time: Duration) -> String {
    if time < Duration::from_mins(1) {
        return format!("{:.1} s", time.as_secs_f64());
    }
    humantime::format_duration(Duration::from_secs(time.as_secs())).to_string()
}

/// Joins a thread and returns its result; passes a panic on.
fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
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
