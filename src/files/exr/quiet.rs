//! Panics of a decoder, which are damage to a file and not news of their own.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`; `None` if it panicked, of which nothing is printed.
pub(super) fn caught<R>(work: impl FnOnce() -> R) -> Option<R> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let loud = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                loud(info);
            }
        }));
    });
    QUIET.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    QUIET.set(false);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_caught_and_the_next_one_is_loud_again() {
        assert_eq!(caught(|| 7), Some(7));
        assert_eq!(caught(|| assert!(QUIET.get(), "outside")), Some(()));
        assert_eq!(caught(|| panic!("never printed")), None::<()>);
        assert!(!QUIET.get());
    }
}
