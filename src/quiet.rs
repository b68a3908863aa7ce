//! Panics of other crates' code that are errors here.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`; `None` if it panicked. The panic hook, which is the program's own matter, hears of
/// it first.
pub(crate) fn caught<R>(work: impl FnOnce() -> R) -> Option<R> {
    QUIET.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    QUIET.set(false);
    result.ok()
}

/// Has nothing printed of panics that are [`caught`]. For the command line, whose process it is.
#[cfg(feature = "cli")]
pub(crate) fn silence_caught() {
    let loud = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !QUIET.get() {
            loud(info);
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_caught_and_the_next_one_is_loud_again() {
        assert_eq!(caught(|| 7), Some(7));
        assert_eq!(caught(|| assert!(QUIET.get(), "outside")), Some(()));
        assert_eq!(caught(|| panic!("caught")), None::<()>);
        assert!(!QUIET.get());
    }
}
