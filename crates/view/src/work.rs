//! Worker threads that keep the window responsive.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};

use wgdenoise::Image;
use wgdenoise::panics::caught;
use wgdenoise_files::escaped;

use crate::compare::Figures;
use crate::denoise::Outcome;
use crate::further::Layer;
use crate::gpu::texture::Texture;
use crate::open::Opened;
use crate::perceived::Perceived;
use crate::picture::Pixels;
use crate::state::entry::Entry;
use crate::state::settling::Stamp;

/// What a thread reports to the window. Tickets tell current results from outdated ones.
pub(crate) enum Report {
    Opened(u64, Result<Loaded, String>),
    Progress(u64, f32),
    Denoised(u64, Result<Outcome, String>),
    Reference(u64, Result<Reference, String>),
    Figures(u64, Result<Figures, String>),
    Perceived(u64, Result<Perceived, String>),
    /// A further layer is ready to show.
    Further(Result<Layer, String>),
    /// A task was out of date.
    Nothing,
    Saved(Result<String, String>),
    /// The watched file has a new version.
    Changed(PathBuf, Stamp),
    /// Files from a dialog; empty if it was dismissed.
    Chosen(Purpose, Vec<PathBuf>),
    /// The system has no dialog for this; carries what it would have suggested.
    NoDialog(Prompt),
    /// The recent files.
    Recent(Vec<Entry>),
    /// A picture of what the window shows, for the clipboard.
    Pictured(Pixels),
    /// A task panicked.
    Failed,
}

/// The purpose of a dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    Open,
    Reference,
    Weights,
    WeightsFolder,
    Save,
    SaveComparison,
}

/// A path for the user to type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Prompt {
    pub(crate) purpose: Purpose,
    pub(crate) path: String,
}

/// A file with its images on the GPU.
pub(crate) struct Loaded {
    pub(crate) opened: Arc<Opened>,
    pub(crate) noisy: Texture,
    pub(crate) albedo: Option<Texture>,
    pub(crate) normal: Option<Texture>,
}

/// The image as it would be with many samples.
pub(crate) struct Reference {
    pub(crate) path: PathBuf,
    pub(crate) image: Arc<Image>,
    pub(crate) texture: Texture,
}

impl Reference {
    /// The file name as shown in the window.
    pub(crate) fn name(&self) -> String {
        escaped(&self.path.file_name().unwrap_or_default().to_string_lossy())
    }
}

/// Where threads leave reports. Each report wakes the window.
#[derive(Clone)]
pub(crate) struct Desk {
    reports: Sender<Report>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Desk {
    pub(crate) fn new(reports: Sender<Report>, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { reports, wake: Arc::new(wake) }
    }

    /// Leaves a report. After the window has closed, nobody reads it.
    pub(crate) fn report(&self, report: Report) {
        let _ = self.reports.send(report);
        (self.wake)();
    }
}

type Task<S> = Box<dyn FnOnce(&mut S) -> Report + Send>;

/// A thread that runs tasks in order, with its own state.
pub(crate) struct Lane<S> {
    tasks: Option<Sender<Task<S>>>,
    thread: Option<JoinHandle<()>>,
}

impl<S: 'static> Lane<S> {
    /// Starts the thread. It creates the state, and recreates it after a panic.
    pub(crate) fn new(desk: Desk, state: impl Fn() -> S + Send + 'static) -> Self {
        let (tasks, inbox) = channel::<Task<S>>();
        let thread = thread::spawn(move || {
            let mut made = state();
            for task in inbox {
                let report = caught(|| task(&mut made)).unwrap_or_else(|| {
                    made = state();
                    Report::Failed
                });
                desk.report(report);
            }
        });
        Self { tasks: Some(tasks), thread: Some(thread) }
    }

    /// Adds a task. The thread ends with the window.
    pub(crate) fn add(&self, task: impl FnOnce(&mut S) -> Report + Send + 'static) {
        if let Some(tasks) = &self.tasks {
            let _ = tasks.send(Box::new(task));
        }
    }

    /// Waits until all tasks are done and the state is dropped; later tasks are ignored.
    pub(crate) fn finish(&mut self) {
        self.tasks = None;
        // Tasks' panics were already reported.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_lane_keeps_order_and_survives_a_panic() {
        let (sender, reports) = channel();
        let mut lane = Lane::new(Desk::new(sender, || {}), || 0);
        lane.add(|count: &mut i32| {
            *count += 1;
            Report::Progress(7, *count as f32)
        });
        lane.add(|_| panic!("this test wants it"));
        lane.add(|count| Report::Progress(8, *count as f32));
        let next = || reports.recv().unwrap();
        assert!(matches!(next(), Report::Progress(7, 1.0)));
        assert!(matches!(next(), Report::Failed));
        assert!(matches!(next(), Report::Progress(8, 0.0)), "its state was made anew");
        lane.add(|_| {
            thread::sleep(Duration::from_millis(100));
            Report::Nothing
        });
        lane.finish();
        assert!(reports.try_recv().is_ok(), "the last task is done");
    }
}
