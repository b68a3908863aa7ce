//! Fuzzes lines of text as command-line arguments, as frame ranges and as file names with a frame
//! number.

#![no_main]

use libfuzzer_sys::fuzz_target;
use wgdenoise_cli::fuzzing::{accepts, name_and_back, parse_frames};

fuzz_target!(|text: &str| {
    accepts(std::iter::once("wgdenoise").chain(text.lines()));
    // One line of each, since a million frames take a while.
    let mut lines = text.lines();
    lines.next().into_iter().for_each(check_frames);
    lines.next().into_iter().for_each(check_pattern);
});

/// Frames must be strictly increasing and within the accepted count.
fn check_frames(text: &str) {
    let Ok(frames) = parse_frames(text) else { return };
    assert!(!frames.is_empty() && frames.len() <= 1_000_000, "{} frames", frames.len());
    assert!(frames.is_sorted_by(|a, b| a < b), "{text:?}");
}

/// The name made from a pattern must parse back to the same frame and not be much longer.
fn check_pattern(pattern: &str) {
    for frame in [0, 7, 1234, -7, -1234, i64::from(u32::MAX)] {
        let Ok(Some((name, back))) = name_and_back(pattern, frame) else { return };
        assert_eq!(back, Some(frame), "{pattern:?} made {name:?}");
        assert!(name.len() <= pattern.len() + 32, "{pattern:?} made {name:?}");
    }
}
