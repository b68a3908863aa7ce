//! Turns panics of dependencies into errors.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` and returns `None` if it panicked. The program's panic hook runs first.
pub fn caught<R>(work: impl FnOnce() -> R) -> Option<R> {
    let outer = CAUGHT.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    CAUGHT.set(outer);
    result.ok()
}

/// Wraps the program's panic hook so that it ignores [`caught`] panics. Only for programs, which
/// own the hook; a library should leave it alone.
pub fn silence_caught() {
    let loud = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !CAUGHT.get() {
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
        assert_eq!(caught(|| assert!(CAUGHT.get(), "outside")), Some(()));
        assert_eq!(caught(|| panic!("caught")), None::<()>);
        let nested = || (caught(|| panic!("inner")), CAUGHT.get());
        assert_eq!(caught(nested), Some((None::<()>, true)));
        assert!(!CAUGHT.get());
    }
}
