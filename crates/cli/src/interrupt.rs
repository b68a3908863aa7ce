//! Ctrl-C and SIGTERM: one sentence, no half-written file, and exit code 130 or 143.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the images written so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally(Arc<AtomicUsize>);

impl Tally {
    pub(crate) fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// The message for a stopped run over this many images, with the state of the `rest`.
    pub(crate) fn last_words(&self, images: usize, rest: &str) -> String {
        match self.0.load(Ordering::Relaxed) {
            0 => "stopped before an image was written".into(),
            written => format!("stopped after {written} of {images} images; {rest}"),
        }
    }
}

/// On the first signal, calls `last` and ends the process; a second signal ends it at once.
#[cfg(unix)]
pub(crate) fn watch(last: impl FnOnce() + Send + 'static) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    let stopping = Arc::default();
    let watched = [SIGINT, SIGTERM].into_iter().try_for_each(|signal| {
        let code = exit_code(signal);
        signal_hook::flag::register_conditional_shutdown(signal, code, Arc::clone(&stopping))?;
        signal_hook::flag::register(signal, Arc::clone(&stopping)).map(|_| ())
    });
    // If watching fails, the system ends the process at once.
    let Ok(mut signals) = watched.and_then(|()| Signals::new([SIGINT, SIGTERM])) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            wgdenoise_files::discard_drafts();
            last();
            end_at_once(exit_code(signal));
        }
    });
}

/// Ends the process without the exit handlers of drivers, which crash while their threads are still
/// at work.
#[cfg(unix)]
pub(crate) fn end_at_once(code: i32) -> ! {
    signal_hook::low_level::exit(code)
}

#[cfg(not(unix))]
pub(crate) fn end_at_once(code: i32) -> ! {
    std::process::exit(code)
}

/// The exit code that shells give a process ended by a signal.
#[cfg(unix)]
fn exit_code(signal: i32) -> i32 {
    128 + signal
}

/// Here the system ends the process at once.
#[cfg(not(unix))]
pub(crate) fn watch(_last: impl FnOnce() + Send + 'static) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_words_tell_what_becomes_of_the_rest_if_there_is_one() {
        let tally = Tally::default();
        let rest = "give --skip-existing to resume";
        assert_eq!(tally.last_words(3, rest), "stopped before an image was written");
        tally.add();
        let words = tally.last_words(3, rest);
        assert_eq!(words, "stopped after 1 of 3 images; give --skip-existing to resume");
    }
}
