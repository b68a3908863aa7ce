//! Output to the user: results on stdout; messages and a progress bar on stderr.

use std::cell::{Cell, RefCell};
use std::collections::HashSet;
use std::io::{IsTerminal, Write};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::Value;

use crate::failure::Failure;
use crate::interrupt::Tally;
use wgdenoise_files::{escaped_json, escaped_lines};

/// How much to print.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    /// Errors only.
    Quiet,
    /// Also what a user should know.
    Normal,
    /// Also adapter, kernels, layers, tiles and times.
    Verbose,
}

/// The severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// One of several images failed; the batch continues.
    Error,
    /// What the program would print: layers, notices, what was written.
    Notice,
}

/// Receives the messages and progress of a run, on the calling thread.
pub trait Host {
    /// Receives a sentence that the program would print on stderr, without the program's name.
    fn message(&self, level: Level, text: &str);

    /// Receives the progress: `done` of `total`, each image counting 1000.
    fn progress(&self, done: u64, total: u64);
}

/// A message and its severity.
pub(crate) type Message = (Level, String);

/// Sends messages to the user, or to the program that hosts this one.
pub(crate) struct Console {
    pub(crate) verbosity: Verbosity,
    said: RefCell<HashSet<String>>,
    /// Messages held until those of an earlier image are printed.
    held: RefCell<Option<Vec<Message>>>,
    progress: RefCell<Option<Progress>>,
    host: Option<Box<dyn Host>>,
}

impl Console {
    pub(crate) fn new(verbosity: Verbosity) -> Self {
        let (said, held, progress) = Default::default();
        Self { verbosity, said, held, progress, host: None }
    }

    /// A console that writes nothing and sends everything to the host.
    pub(crate) fn of_host(verbosity: Verbosity, host: Box<dyn Host>) -> Self {
        Self { host: Some(host), ..Self::new(verbosity) }
    }

    /// Reports a failure, whatever the verbosity.
    pub(crate) fn error(&self, failure: &Failure) {
        self.say(Level::Error, &failure.to_string());
    }

    /// Prints what a user should know.
    pub(crate) fn notice(&self, text: &str) {
        if self.verbosity >= Verbosity::Normal {
            self.say(Level::Notice, text);
        }
    }

    /// Prints a notice once, however many images it applies to; `about` names the first one.
    pub(crate) fn notice_once(&self, about: &str, text: &str) {
        if self.said.borrow_mut().insert(text.into()) {
            self.notice(&format!("{about}{text}"));
        }
    }

    /// Prints what only `--verbose` shows.
    pub(crate) fn detail(&self, text: impl FnOnce() -> String) {
        if self.verbosity >= Verbosity::Verbose {
            self.say(Level::Notice, &text());
        }
    }

    /// Holds messages back from now on.
    pub(crate) fn hold(&self) {
        self.held.borrow_mut().get_or_insert_default();
    }

    /// Ends [`hold`](Self::hold) and returns what was held back.
    pub(crate) fn release(&self) -> Vec<Message> {
        self.held.take().unwrap_or_default()
    }

    /// Prints messages that were held back.
    pub(crate) fn say_all(&self, held: &[Message]) {
        for (level, text) in held {
            self.say(*level, text);
        }
    }

    fn say(&self, level: Level, text: &str) {
        if let Some(held) = &mut *self.held.borrow_mut() {
            return held.push((level, text.into()));
        }
        match &self.host {
            Some(host) => host.message(level, &escaped_lines(text)),
            None => self.write(level, text),
        }
    }

    /// Ignores write errors: a message that nobody can read is no reason to lose the work.
    fn write(&self, level: Level, text: &str) {
        let kind = if level == Level::Error { "error: " } else { "" };
        let text = escaped_lines(&format!("{kind}{text}"));
        let write = || {
            let _ = writeln!(std::io::stderr(), "wgdenoise: {text}");
        };
        match &*self.progress.borrow() {
            Some(progress) => progress.bar.suspend(write),
            None => write(),
        }
    }

    /// Starts a progress bar over this many items, if a person or a host is watching.
    pub(crate) fn begin(&self, items: usize) {
        let is_seen = self.verbosity >= Verbosity::Normal && std::io::stderr().is_terminal();
        *self.progress.borrow_mut() = match &self.host {
            Some(_) => Some(Progress::hidden(items)),
            None => is_seen.then(|| Progress::hidden(items).appearing()),
        };
    }

    /// Moves the bar to the start of an item, counted from 0.
    pub(crate) fn item(&self, index: usize, name: &str) {
        if let Some(progress) = &*self.progress.borrow() {
            progress.item(index, name);
            self.tell_host(progress);
        }
    }

    /// Moves the bar within the item, `done` from 0 to 1.
    pub(crate) fn within_item(&self, done: f64) {
        if let Some(progress) = &*self.progress.borrow() {
            progress.within_item(done);
            self.tell_host(progress);
        }
    }

    fn tell_host(&self, Progress { bar, items, .. }: &Progress) {
        if let Some(host) = &self.host {
            host.progress(bar.position(), *items as u64 * STEPS);
        }
    }

    /// An action that clears the bar and reports that a run over this many images was stopped.
    pub(crate) fn last_words(
        &self,
        tally: Tally,
        images: usize,
        rest: &'static str,
    ) -> impl FnOnce() + Send + use<> {
        let bar = self.progress.borrow().as_ref().map(|progress| progress.bar.clone());
        move || {
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
            let _ = writeln!(std::io::stderr(), "wgdenoise: {}", tally.last_words(images, rest));
        }
    }

    /// Removes the bar.
    pub(crate) fn end(&self) {
        self.progress.take();
    }
}

/// Writes a result to stdout. A reader that has gone away is not a failure.
pub(crate) fn print(result: &str) -> Result<(), Failure> {
    write(&escaped_lines(result))
}

/// Writes a result as JSON.
pub(crate) fn print_json(result: &Value) -> Result<(), Failure> {
    write(&escaped_json(&result.to_string()))
}

fn write(text: &str) -> Result<(), Failure> {
    print_bytes(format!("{text}\n").as_bytes())
}

/// Writes bytes to stdout as they are.
pub(crate) fn print_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("stdout: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Work that takes less time than this gets no bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Steps of the bar per item.
const STEPS: u64 = 1000;
const TEMPLATE: &str = "{spinner} {msg} [{wide_bar}] {percent:>3} %, {time}";

/// A bar on stderr.
#[derive(Debug)]
struct Progress {
    bar: ProgressBar,
    items: usize,
    index: Cell<usize>,
    /// Drop it to keep the bar from appearing.
    patience: Option<Sender<()>>,
    appearance: Option<JoinHandle<()>>,
}

impl Progress {
    fn hidden(items: usize) -> Self {
        let hidden = ProgressDrawTarget::hidden();
        let bar = ProgressBar::with_draw_target(Some(items as u64 * STEPS), hidden);
        Self { bar, items, index: Cell::new(0), patience: None, appearance: None }
    }

    /// Makes the bar appear on stderr if the work takes long.
    fn appearing(mut self) -> Self {
        let style = ProgressStyle::with_template(TEMPLATE).expect("the template is well-formed");
        let style =
            style.with_key("time", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                let _ = text.write_str(&time(state.pos(), state.elapsed(), state.eta()));
            });
        let (patience, done) = channel();
        let shown = self.bar.clone().with_style(style);
        // Needs its own thread, because the first step alone may take longer.
        let appearance = thread::spawn(move || {
            if done.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(Duration::from_millis(100));
            }
        });
        (self.patience, self.appearance) = (Some(patience), Some(appearance));
        self
    }

    fn item(&self, index: usize, name: &str) {
        self.index.set(index);
        self.bar.set_message(match self.items {
            1 => name.into(),
            items => format!("{name} ({} of {items})", index + 1),
        });
        self.bar.set_position(index as u64 * STEPS);
    }

    fn within_item(&self, done: f64) {
        let steps = (self.index.get() as f64 + done) * STEPS as f64;
        self.bar.set_position(steps.round() as u64);
    }
}

/// The time left, or the time so far while that is unknown.
fn time(position: u64, elapsed: Duration, left: Duration) -> String {
    match position {
        0 => format!("{:#} so far", HumanDuration(elapsed)),
        _ => format!("{:#} left", HumanDuration(left)),
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.patience = None;
        let _ = self.appearance.take().map(JoinHandle::join);
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_shows_the_image_the_count_and_the_way_through_all_images() {
        let progress = Progress::hidden(4);
        progress.item(2, "beauty.0007.exr");
        assert_eq!(progress.bar.message(), "beauty.0007.exr (3 of 4)");
        assert_eq!((progress.bar.position(), progress.bar.length()), (2000, Some(4000)));
        progress.within_item(0.25);
        assert_eq!(progress.bar.position(), 2250);
        // A frame that starts over with smaller tiles moves back, but not into the next image.
        progress.within_item(0.0);
        progress.within_item(1.0);
        assert_eq!(progress.bar.position(), 3000);
        let single = Progress::hidden(1);
        single.item(0, "render.exr");
        assert_eq!(single.bar.message(), "render.exr");
    }

    #[test]
    fn the_time_left_is_shown_as_soon_as_it_is_known() {
        let seconds = Duration::from_secs;
        assert_eq!(time(0, seconds(3), seconds(0)), "3s so far");
        assert_eq!(time(1, seconds(3), seconds(90)), "2m left");
    }

    #[test]
    fn a_sentence_is_told_once() {
        let console = Console::new(Verbosity::Quiet);
        console.notice_once("a.exr: ", "text");
        console.notice_once("b.exr: ", "text");
        assert_eq!(console.said.borrow().len(), 1);
    }
}
