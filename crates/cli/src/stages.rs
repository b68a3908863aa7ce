//! The stages of an image: read, denoised and written, with the time each took.

use std::sync::Arc;
use std::time::Instant;

use crate::failure::Failure;
use crate::plan::Job;
use wgdenoise_files::{Denoised, Picture, exposed};

/// An image that was read.
pub(crate) struct Read {
    pub(crate) picture: Picture,
    pub(crate) laps: Laps,
}

/// An image ready to be written.
pub(crate) struct Ready {
    pub(crate) picture: Arc<Picture>,
    /// One result per view.
    pub(crate) results: Vec<Denoised>,
    pub(crate) laps: Laps,
}

/// Messages about a written image.
pub(crate) struct Written {
    pub(crate) notices: Vec<String>,
    pub(crate) laps: Laps,
}

pub(crate) fn read(job: &Job) -> Result<Read, Failure> {
    let mut laps = Laps::start();
    let picture = Picture::open(&job.input, &job.layers)?;
    laps.lap("read");
    Ok(Read { picture, laps })
}

pub(crate) fn write(job: &Job, image: Ready, exposure: Option<f32>) -> Result<Written, Failure> {
    let Ready { picture, mut results, mut laps } = image;
    laps.resume();
    if job.format.is_display_referred() {
        let expose = |image: Denoised| Denoised {
            color: exposed(image.color, exposure.unwrap_or(0.0)),
            ..image
        };
        results = results.into_iter().map(expose).collect();
    }
    let notices = picture.save_as(&job.output, job.format, &results, job.replace)?;
    laps.lap("written");
    Ok(Written { notices, laps })
}

/// How long the steps of an image took.
pub(crate) struct Laps {
    last: Instant,
    notes: Vec<String>,
}

impl Laps {
    fn start() -> Self {
        Self { last: Instant::now(), notes: Vec::new() }
    }

    /// Restarts the clock, so that the time since the last step does not count.
    pub(crate) fn resume(&mut self) {
        self.last = Instant::now();
    }

    /// Records the time since the last step.
    pub(crate) fn lap(&mut self, what: &str) {
        let now = Instant::now();
        let lap = now.duration_since(std::mem::replace(&mut self.last, now));
        self.notes.push(format!("{what} in {lap:.1?}"));
    }
}

impl std::fmt::Display for Laps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.notes.join(", "))
    }
}
