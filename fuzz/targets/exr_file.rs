//! Bytes as an EXR file: refused, or read, written again and then read with the same colour.

#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use wgdenoise::files::{Description, LayerChoice, Picture};

/// A folder in memory, where there is one.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let parent = if memory.is_dir() { memory } else { std::env::temp_dir() };
    tempfile::tempdir_in(parent).expect("a temporary folder")
});

/// A few bytes may rightly stand for a large picture of one colour. Larger ones than this are
/// only described, so that the limits on memory and time find what a file does not back.
const MOST_PIXELS: u64 = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    // Other formats are told by their first bytes and have other readers.
    if !bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return;
    }
    let (read, written) = (FOLDER.path().join("in.exr"), FOLDER.path().join("out.exr"));
    fs::write(&read, bytes).expect("memory");
    let choice = LayerChoice::default();
    let Ok(description) = Description::of(&read, &choice) else { return };
    if u64::from(description.width) * u64::from(description.height) > MOST_PIXELS {
        return;
    }
    let Ok(picture) = Picture::open(&read, &choice) else { return };
    if picture.save(&written, picture.color(), true).is_err() {
        return;
    }
    let again = Picture::open(&written, &choice).expect("what was written can be read");
    assert_eq!(again.color().size(), picture.color().size());
});
