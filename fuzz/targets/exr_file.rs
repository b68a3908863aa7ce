//! Fuzzes bytes as an EXR file: rejected, or read, written and read again at the same size.

#![no_main]

use std::fs;
use std::panic;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use wgdenoise_files::{Denoised, Description, LayerChoice, Limits, Picture};

/// A folder in memory, if available.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let parent = if memory.is_dir() { memory } else { std::env::temp_dir() };
    tempfile::tempdir_in(parent).expect("a temporary folder")
});

/// A few bytes can validly encode a large image of one color with hundreds of channels. Accepting
/// only small images lets the memory and time limits expose claims that a file cannot back.
const LIMITS: Limits = Limits { pixels: 1 << 16 };

/// Keeps libFuzzer's hook from ending the process on the EXR decoder's panics, which the program
/// catches where it expects them. An uncaught panic still ends the process.
fn leave_the_decoders_panics() {
    let fatal = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|place| place.file().contains("/exr-")) {
            fatal(info);
        }
    }));
}

fuzz_target!(init: leave_the_decoders_panics(), |bytes: &[u8]| {
    // The first bytes select the format; others have their own readers.
    if !bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return;
    }
    let (read, written) = (FOLDER.path().join("in.exr"), FOLDER.path().join("out.exr"));
    fs::write(&read, bytes).expect("memory");
    let choice = LayerChoice { limits: LIMITS, ..LayerChoice::default() };
    let described = Description::of(&read, &choice);
    let Ok(picture) = Picture::open(&read, &choice) else { return };
    assert!(described.is_ok(), "{described:?}");
    let results: Vec<_> = picture.views().iter().map(|v| Denoised::from(v.color().clone())).collect();
    if picture.save(&written, &results, true).is_err() {
        return;
    }
    let again = Picture::open(&written, &choice).expect("what was written can be read");
    let sizes = |picture: &Picture| picture.views().iter().map(|v| v.color().size()).collect();
    let (before, after): (Vec<_>, Vec<_>) = (sizes(&picture), sizes(&again));
    assert_eq!(after, before);
});
