//! Outputs that cannot be written, or only partly, and missing folders.

use std::fs;
use std::os::unix::process::ExitStatusExt;

use crate::support::{Folder, Run, WEIGHTS};

/// Makes a shell reject files larger than 16 KiB, like a full disk.
const FULL: &str = "trap '' XFSZ; ulimit -f 32";
/// The same limit, but the system kills the program while it writes.
const DEADLY: &str = "ulimit -c 0; ulimit -f 32";
const SIGXFSZ: i32 = 25;

/// A folder with `out.exr`, which a result of more than 60 KiB would replace.
fn old_result() -> Folder {
    let folder = Folder::new();
    folder.copy("blender4_single_part.exr");
    fs::write(folder.path("out.exr"), "old").unwrap();
    folder
}

const ARGS: [&str; 6] =
    ["blender4_single_part.exr", "out.exr", "--force", "-q", "--weights", WEIGHTS];

#[test]
fn a_disk_that_fills_up_leaves_the_old_file_and_nothing_else() {
    let folder = old_result();
    let mut command = folder.command_after(FULL, &ARGS);
    let run = Run::of(&command.env("MESA_SHADER_CACHE_DISABLE", "true").output().unwrap());
    run.assert_failed(1, &["out.exr: cannot be written: File too large"]);
    assert_eq!(fs::read(folder.path("out.exr")).unwrap(), b"old");
    assert_eq!(folder.names(), ["blender4_single_part.exr", "out.exr"]);
}

#[test]
fn a_program_that_is_ended_while_it_writes_leaves_the_old_file_and_nothing_else() {
    let folder = old_result();
    let mut command = folder.command_after(DEADLY, &ARGS);
    let output = command.env("MESA_SHADER_CACHE_DISABLE", "true").output().unwrap();
    assert_eq!(output.status.signal(), Some(SIGXFSZ), "{output:?}");
    assert_eq!(fs::read(folder.path("out.exr")).unwrap(), b"old");
    assert_eq!(folder.names(), ["blender4_single_part.exr", "out.exr"]);
}

/// Even root cannot create a file in this folder; the error comes before a GPU is opened.
#[test]
fn a_folder_that_takes_no_file_is_refused_before_the_work() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let args = ["plain_rgb.exr", "/proc/out.exr", "--adapter", "nosuch"];
    folder.denoise(&args).assert_failed(1, &["/proc/out.exr: cannot be written: "]);
}

/// No file system accepts a name longer than 255 bytes; the error comes before a GPU is opened.
#[test]
fn a_name_that_is_too_long_is_refused_before_the_work() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let long = format!("{}.exr", "x".repeat(255));
    let args = ["plain_rgb.exr", &long, "--adapter", "nosuch"];
    folder.denoise(&args).assert_failed(1, &["x.exr: cannot be written: File name too long"]);
    assert_eq!(folder.names(), ["plain_rgb.exr"]);
}

#[test]
fn a_result_goes_through_a_link_and_into_a_folder() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    fs::create_dir(folder.path("inner")).unwrap();
    fs::write(folder.path("inner/real.exr"), "old").unwrap();
    std::os::unix::fs::symlink("inner/real.exr", folder.path("link.exr")).unwrap();
    folder.denoise(&["plain_rgb.exr", "link.exr", "--force"]).assert_done();
    assert!(fs::symlink_metadata(folder.path("link.exr")).unwrap().is_symlink());
    folder.denoise(&["plain_rgb.exr", "inner"]).assert_done();
    let [through, into] = ["inner/real.exr", "inner/plain_rgb.exr"].map(|p| folder.path(p));
    assert!(fs::read(through).unwrap() == fs::read(into).unwrap());
}

#[test]
fn missing_folders_are_created_only_if_asked() {
    let folder = Folder::new();
    for name in ["plain_rgb.exr", "karma_like.exr"] {
        folder.copy(name);
    }
    let one = ["plain_rgb.exr", "a/b/out.exr"];
    folder.denoise(&one).assert_failed(1, &["the folder a/b does not exist", "--parents"]);
    let several = ["plain_rgb.exr", "karma_like.exr", "c/d"];
    folder.denoise(&several).assert_failed(1, &["c/d: ", "--parents"]);
    let preview = ["preview", "plain_rgb.exr", "e/look.png"];
    folder.run(&preview).assert_failed(1, &["the folder e does not exist", "--parents"]);
    // An output rejected for another reason leaves no folder behind.
    folder
        .denoise(&["plain_rgb.exr", "a/out.tiff", "--parents"])
        .assert_failed(2, &["its name must end in"]);
    assert_eq!(folder.names(), ["karma_like.exr", "plain_rgb.exr"]);

    folder.denoise(&[&one[..], &["--parents"]].concat()).assert_done();
    folder.denoise(&[&several[..], &["--parents"]].concat()).assert_done();
    folder.run(&[&preview[..], &["--parents"]].concat()).assert_done();
    for name in ["a/b/out.exr", "c/d/plain_rgb.exr", "c/d/karma_like.exr", "e/look.png"] {
        assert!(folder.path(name).is_file(), "{name}");
    }
}
