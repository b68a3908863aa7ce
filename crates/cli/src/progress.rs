//! A bar on stderr for work that takes over a second, if a person is watching.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

const PATIENCE: Duration = Duration::from_secs(1);
const TEMPLATE: &str = "{spinner} {elapsed} [{wide_bar}] {pos}/{len} {msg}";

/// Draws from a thread of its own: the first step alone may take longer than a second.
pub(super) struct Progress {
    steps: Option<Sender<[u64; 2]>>,
    drawing: Option<JoinHandle<()>>,
}

impl Progress {
    /// A bar of `len` steps of a `unit`; one that never shows if `quiet` or stderr is no terminal.
    pub(super) fn new(len: usize, unit: &'static str, quiet: bool) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Self { steps: None, drawing: None };
        }
        let (sender, receiver) = channel();
        let drawing = thread::spawn(move || draw(&receiver, len as u64, unit));
        Self { steps: Some(sender), drawing: Some(drawing) }
    }

    /// Says how many steps are done, of how many.
    pub(super) fn set(&self, done: usize, len: usize) {
        // A bar that has gone away is no reason to stop.
        let _ = self.steps.as_ref().map(|steps| steps.send([done, len].map(|n| n as u64)));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.steps = None;
        let _ = self.drawing.take().map(JoinHandle::join);
    }
}

/// Waits a second, then shows what arrives until the sender is gone.
fn draw(steps: &Receiver<[u64; 2]>, mut len: u64, unit: &'static str) {
    let mut done = 0;
    let begin = std::time::Instant::now();
    while let Some(left) = PATIENCE.checked_sub(begin.elapsed()) {
        match steps.recv_timeout(left) {
            Ok(now) => [done, len] = now,
            Err(RecvTimeoutError::Timeout) => break,
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
    let style = ProgressStyle::with_template(TEMPLATE).expect("the template is well-formed");
    let bar = ProgressBar::new(len).with_style(style).with_elapsed(begin.elapsed());
    bar.set_message(unit);
    bar.set_position(done);
    bar.enable_steady_tick(Duration::from_millis(100));
    for [done, len] in steps {
        bar.set_length(len);
        bar.set_position(done);
    }
    bar.finish_and_clear();
}
