//! Everything that is open, and the work being done on it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};

use crate::compare::Figures;
use crate::denoise::{Engine, Outcome};
use crate::further::Further;
use crate::gpu::host::Gpu;
use crate::open::{Opened, Wish};
use crate::perceiving::Perceiving;
use crate::picture::Pixels;
use crate::recent::Recent;
use crate::state::latest::Latest;
use crate::state::looking::Looking;
use crate::state::pending::Pending;
use crate::state::sequence::Sequence;
use crate::state::settings::Settings;
use crate::state::tone::Tone;
use crate::state::transform::Transform;
use crate::watch::Watch;
use crate::work::{Desk, Lane, Loaded, Prompt, Reference, Report};

/// A message for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    pub(crate) text: String,
    pub(crate) is_error: bool,
}

/// The state of the window.
pub(crate) struct Session {
    pub(crate) looking: Looking,
    pub(crate) transform: Transform,
    pub(crate) tone: Tone,
    pub(crate) settings: Settings,
    pub(crate) loaded: Option<Loaded>,
    pub(crate) denoised: Option<Arc<Outcome>>,
    pub(crate) reference: Option<Reference>,
    pub(crate) figures: Option<Figures>,
    pub(crate) sequence: Option<Sequence>,
    /// The file's layers that could be the color.
    pub(crate) colors: Vec<String>,
    /// The user's choices for the open file, or for the one being read.
    pub(crate) wish: Wish,
    /// The further layers being edited, in the syntax of `--layers`.
    pub(crate) patterns: String,
    pub(crate) further: Further,
    pub(crate) watch: Option<Watch>,
    pub(crate) recent: Recent,
    /// What the user is to type a path for, where the system has no dialog.
    pub(crate) prompt: Option<Prompt>,
    pub(crate) message: Option<Message>,
    /// The running denoising's completed share, from 0 to 1.
    pub(crate) progress: Option<f32>,
    pub(crate) opening: Pending,
    pub(crate) shows_help: bool,
    /// The image area, in screen pixels.
    pub(crate) area: [f32; 2],
    /// Whether the split line is being dragged.
    pub(crate) drags_line: bool,
    /// The pixel under the cursor.
    pub(crate) pointed: Option<[u32; 2]>,
    /// A picture to put on the clipboard.
    pub(crate) copied: Option<Pixels>,
    pub(crate) perceiving: Perceiving,
    pub(crate) desk: Desk,
    pub(crate) gpu: Gpu,
    files: Lane<()>,
    /// Figures have their own thread, so that files do not wait for them.
    judging: Lane<()>,
    engine: Lane<Engine>,
    reports: Receiver<Report>,
    /// The latest denoising request; the engine's thread skips older ones.
    denoising: Latest,
    /// Stops the running denoising.
    stop: Arc<AtomicBool>,
}

impl Session {
    /// Creates an empty session. `wake` makes the window redraw, from any thread.
    pub(crate) fn new(gpu: Gpu, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (sender, reports) = channel();
        let desk = Desk::new(sender, wake);
        let for_engine = gpu.clone();
        Self {
            looking: Looking::default(),
            transform: Transform::default(),
            tone: Tone::default(),
            settings: Settings::default(),
            loaded: None,
            denoised: None,
            reference: None,
            figures: None,
            sequence: None,
            colors: Vec::new(),
            wish: Wish::default(),
            patterns: String::new(),
            further: Further::default(),
            watch: None,
            recent: Recent::default(),
            prompt: None,
            message: None,
            progress: None,
            opening: Pending::default(),
            shows_help: false,
            area: [1.0; 2],
            drags_line: false,
            pointed: None,
            copied: None,
            perceiving: Perceiving::new(desk.clone()),
            files: Lane::new(desk.clone(), || ()),
            judging: Lane::new(desk.clone(), || ()),
            engine: Lane::new(desk.clone(), move || Engine::new(for_engine.clone())),
            desk,
            gpu,
            reports,
            denoising: Latest::default(),
            stop: Arc::default(),
        }
    }

    pub(crate) fn opened(&self) -> Option<&Arc<Opened>> {
        self.loaded.as_ref().map(|loaded| &loaded.opened)
    }

    pub(crate) fn is_denoising(&self) -> bool {
        self.progress.is_some()
    }

    /// Whether the settings have no result: it failed, was canceled, or is pending.
    pub(crate) fn is_outdated(&self) -> bool {
        self.denoised.as_ref().is_none_or(|denoised| denoised.settings != self.settings)
    }

    pub(crate) fn tell(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: false });
    }

    pub(crate) fn fail(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: true });
    }

    /// Denoises the open image, in place of any running denoising.
    pub(crate) fn denoise(&mut self) {
        let Some(opened) = self.opened().cloned() else { return };
        let ticket = self.next_ticket();
        (self.progress, self.message) = (Some(0.0), None);
        let (latest, settings) = (self.denoising.clone(), self.settings.clone());
        let (desk, stop) = (self.desk.clone(), self.stop.clone());
        self.engine.add(move |engine| {
            if !latest.is(ticket) {
                return Report::Nothing;
            }
            let mut progress = |done| desk.report(Report::Progress(ticket, done));
            Report::Denoised(ticket, engine.denoise(&opened, &settings, &stop, &mut progress))
        });
    }

    /// Stops the running denoising. Recomputes figures, because pending ones are dropped.
    pub(crate) fn cancel(&mut self) {
        self.next_ticket();
        self.progress = None;
        self.compare();
    }

    /// Runs work on the file thread.
    pub(crate) fn in_background(&self, work: impl FnOnce() -> Report + Send + 'static) {
        self.files.add(move |()| work());
    }

    /// Stops running work and starts a new ticket.
    fn next_ticket(&mut self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        self.stop = Arc::default();
        self.denoising.next()
    }

    /// Takes the threads' reports since the last call.
    pub(crate) fn take_reports(&mut self) -> Vec<Report> {
        let mut others = Vec::new();
        while let Ok(report) = self.reports.try_recv() {
            match report {
                Report::Opened(ticket, loaded) => self.take_opened(ticket, loaded),
                Report::Reference(ticket, reference) => self.take_reference(ticket, reference),
                Report::Denoised(ticket, result) if self.denoising.is(ticket) => {
                    self.finish(result);
                }
                Report::Progress(ticket, done) if self.denoising.is(ticket) => {
                    self.progress = Some(done);
                }
                Report::Figures(ticket, figures) if self.denoising.is(ticket) => {
                    self.judge(figures);
                }
                Report::Denoised(..) | Report::Progress(..) | Report::Figures(..) => {}
                Report::Failed => self.give_up(),
                other => others.push(other),
            }
        }
        others
    }

    fn finish(&mut self, result: Result<Outcome, String>) {
        self.progress = None;
        match result {
            Ok(outcome) => {
                if let Some(notice) = outcome.notices.first() {
                    self.tell(notice.clone());
                }
                self.denoised = Some(Arc::new(outcome));
                self.compare();
            }
            Err(error) => self.fail(error),
        }
    }

    /// Stops all work after a panic.
    fn give_up(&mut self) {
        self.next_ticket();
        self.progress = None;
        self.cancel_opening();
        self.fail("an error inside the program stopped the work; please report it");
    }

    fn judge(&mut self, figures: Result<Figures, String>) {
        match figures {
            Ok(figures) => self.figures = Some(figures),
            Err(error) => {
                self.figures = None;
                self.fail(error);
            }
        }
    }

    /// Computes the figures of the open images.
    pub(crate) fn compare(&mut self) {
        let Some(opened) = self.opened().cloned() else { return };
        let reference = self.reference.as_ref().filter(|_| self.available().reference);
        let reference = reference.map(|reference| reference.image.clone());
        let outcome = self.denoised.clone();
        let ticket = self.denoising.current();
        self.judging.add(move |()| {
            let denoised = outcome.as_ref().map(|outcome| &outcome.results[opened.shown].color);
            let figures = Figures::of(opened.view().color(), denoised, reference.as_deref());
            Report::Figures(ticket, figures)
        });
    }
}

impl Drop for Session {
    /// Stops what runs, but lets a file finish saving. A driver that unloads while a thread still
    /// uses it would crash the program.
    fn drop(&mut self) {
        self.next_ticket();
        self.cancel_opening();
        self.engine.finish();
        self.files.finish();
    }
}
