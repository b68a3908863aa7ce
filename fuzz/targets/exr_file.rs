//! Bytes as an EXR file: refused, or read, written again and then read with the same colour.

#![no_main]

use std::fs;
use std::panic;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use wgdenoise_files::{Description, LayerChoice, Limits, Picture};

/// A folder in memory, where there is one.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let parent = if memory.is_dir() { memory } else { std::env::temp_dir() };
    tempfile::tempdir_in(parent).expect("a temporary folder")
});

/// A few bytes may rightly stand for a large picture of one colour, in hundreds of channels. Only
/// small ones are accepted, so that the limits on memory and time find what a file does not back.
const LIMITS: Limits = Limits { pixels: 1 << 16 };

/// Leaves panics of the EXR decoder to the program, which catches them where it knows of them:
/// libFuzzer's hook would end the process. One that nothing catches ends it all the same.
fn leave_the_decoders_panics() {
    let fatal = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|place| place.file().contains("/exr-")) {
            fatal(info);
        }
    }));
}

fuzz_target!(init: leave_the_decoders_panics(), |bytes: &[u8]| {
    // Other formats are told by their first bytes and have other readers.
    if !bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return;
    }
    let (read, written) = (FOLDER.path().join("in.exr"), FOLDER.path().join("out.exr"));
    fs::write(&read, bytes).expect("memory");
    let choice = LayerChoice { limits: LIMITS, ..LayerChoice::default() };
    let described = Description::of(&read, &choice);
    let Ok(picture) = Picture::open(&read, &choice) else { return };
    assert!(described.is_ok(), "{described:?}");
    if picture.save(&written, picture.color(), true).is_err() {
        return;
    }
    let again = Picture::open(&written, &choice).expect("what was written can be read");
    assert_eq!(again.color().size(), picture.color().size());
});
