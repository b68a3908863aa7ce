//! Runs only on Linux, where an environment variable relocates the cache; and only Vulkan has this
//! cache.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::PathBuf;

use crate::support::{Folder, Run, WEIGHTS};

/// Runs with a cache inside the folder and returns the output.
fn run(folder: &Folder) -> Vec<u8> {
    let args = ["plain_rgb.exr", "out.exr", "--force", "--quiet", "--weights", WEIGHTS];
    let mut command = folder.command(&args);
    let run = Run::of(&command.env("XDG_CACHE_HOME", folder.path("cache")).output().unwrap());
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
    fs::read(folder.path("out.exr")).unwrap()
}

/// The only file with compiled pipelines.
fn kept(folder: &Folder) -> PathBuf {
    let entries = fs::read_dir(folder.path("cache/wgdenoise")).expect("the first run made it");
    let paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    assert_eq!(paths.len(), 1, "{paths:?}");
    paths[0].clone()
}

#[test]
fn compiled_kernels_are_kept_for_the_next_run_and_replaced_if_unusable() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let picture = run(&folder);
    let file = kept(&folder);
    let whole = fs::read(&file).unwrap();
    let begin = format!("wgdenoise pipelines\n{}; ", file.file_name().unwrap().to_str().unwrap());
    assert!(whole.starts_with(begin.as_bytes()), "{}", String::from_utf8_lossy(&whole));
    assert_eq!(run(&folder), picture);
    assert_eq!(kept(&folder), file);

    let garbage = vec![0xff; 100_000];
    let mut changed = whole.clone();
    *changed.last_mut().unwrap() ^= 1;
    let old = [&whole[..begin.len()], b"of old", &whole[begin.len()..]].concat();
    for bytes in [&[], &whole[..whole.len() / 2], &garbage, &changed, &old] {
        fs::write(&file, bytes).unwrap();
        assert_eq!(run(&folder), picture);
        let replaced = fs::read(kept(&folder)).unwrap();
        assert!(replaced != bytes && replaced.starts_with(begin.as_bytes()), "{replaced:?}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_no_failure() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    fs::create_dir(folder.path("cache")).unwrap();
    fs::write(folder.path("cache/wgdenoise"), "a file where a folder should be").unwrap();
    run(&folder);
    assert!(folder.path("cache/wgdenoise").is_file());
}
