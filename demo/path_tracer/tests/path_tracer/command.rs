//! The command writes frames and rejects invalid requests.

use std::path::Path;
use std::process::Command;

use wgdenoise_files::{LayerChoice, MotionWish, Picture};

/// Runs the command with tiny images of one sample; returns its error output.
fn run(folder: &Path, args: &str) -> Result<(), String> {
    let output = Command::new(env!("CARGO_BIN_EXE_path_tracer"))
        .args("--size 16x12 --spp 1".split(' '))
        .args(args.split(' '))
        .current_dir(folder)
        .output()
        .expect("the command starts");
    if output.status.success() {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into())
    }
}

#[test]
fn frames_have_numbers_and_all_layers() {
    let folder = tempfile::tempdir().expect("a folder");
    let args =
        "--frames 2 --temporal --animate --orbit -1 --start 0.5 --out a.exr --reference r.exr";
    run(folder.path(), &format!("{args} --reference-spp 2")).expect("it succeeds");
    let mut names: Vec<_> = std::fs::read_dir(folder.path())
        .expect("the folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("text"))
        .collect();
    names.sort();
    let frame =
        |n| [format!("a.000{n}.exr"), format!("a.denoised.000{n}.exr"), format!("r.000{n}.exr")];
    let mut expected: Vec<_> = [1, 2].into_iter().flat_map(frame).collect();
    expected.sort();
    assert_eq!(names, expected);
    let path = folder.path().join("a.0002.exr");
    let choice = LayerChoice { motion: MotionWish::Auto, ..Default::default() };
    let picture = Picture::open(&path, &choice).expect("the file is read");
    assert!(picture.first().albedo().is_some() && picture.first().normal().is_some());
    assert!(picture.first().motion().is_some(), "`wgdenoise --temporal` finds the motion vectors");
}

#[test]
fn what_makes_no_sense_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, named) in [
        ("--temporal --out a.exr", "--frames"),
        ("--animate --out a.exr", "--frames"),
        ("--frames 2", "--out"),
        ("--frames 2 --out a.exr --denoised a.exr", "a.0001.exr is named twice"),
        ("--frames 2 --out a.exr --orbit inf", "-180 to 180"),
        ("--frames 2 --out a.exr --start -1", "0 to 100000"),
    ] {
        let error = run(folder.path(), args).expect_err(args);
        assert!(error.contains(named) && !error.contains("panicked"), "{args}: {error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
}
