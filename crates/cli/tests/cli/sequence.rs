//! Several images in one run.

use std::fs;

use crate::support::{Folder, data};

/// A folder with images of several sizes and layers as frames 1, 2 and 10, and an empty folder.
fn animation() -> Folder {
    let folder = Folder::new();
    for (frame, file) in [(1, "plain_rgb.exr"), (2, "rgba_zips.exr"), (10, "karma_like.exr")] {
        fs::copy(data(file), folder.path(&format!("beauty.{frame:04}.exr"))).unwrap();
    }
    fs::create_dir(folder.path("clean")).unwrap();
    folder
}

impl Folder {
    fn names_in(&self, inner: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(inner)).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

#[test]
fn one_denoiser_serves_all_frames_and_each_comes_out_as_if_alone() {
    let folder = animation();
    let run = folder.denoise(&["beauty.####.exr", "clean/c.%04d.exr", "-v"]);
    run.assert_done();
    assert_eq!(folder.names_in("clean"), ["c.0001.exr", "c.0002.exr", "c.0010.exr"]);
    assert!(
        run.stderr
            .lines()
            .last()
            .is_some_and(|line| line.starts_with("wgdenoise: wrote 3 images in ")),
        "{run:?}"
    );
    let count = |text: &str| run.stderr.matches(text).count();
    assert_eq!((count("prepared in"), count("written in")), (1, 3), "{run:?}");
    assert!(run.stderr.contains("wgdenoise: beauty.0010.exr: color from `C`"), "{run:?}");
    for frame in ["0001", "0010"] {
        folder.denoise(&[&format!("beauty.{frame}.exr"), "alone.exr", "--force"]).assert_done();
        let (alone, among) = (folder.path("alone.exr"), format!("clean/c.{frame}.exr"));
        assert!(fs::read(alone).unwrap() == fs::read(folder.path(&among)).unwrap(), "{frame}");
    }
}

/// The messages without their times.
fn told(stderr: &str) -> Vec<String> {
    let line = |line: &str| match line.split_once(" in ") {
        Some((before, _)) if line.contains("written in") => before.into(),
        Some(("wgdenoise: wrote 2 of 3 images", _)) => "the sum".into(),
        _ => line.to_string(),
    };
    stderr.lines().map(line).collect()
}

#[test]
fn overlapped_frames_come_out_and_are_told_of_as_one_after_the_other() {
    let folder = animation();
    fs::write(folder.path("beauty.0002.exr"), "").unwrap();
    let all = ["beauty.####.exr", "clean", "-v", "--force", "--kernels", "simd"];
    let results = || {
        ["0001", "0010"].map(|n| fs::read(folder.path(&format!("clean/beauty.{n}.exr"))).unwrap())
    };
    let one_by_one = folder.denoise(&[&all[..], &["--no-overlap"]].concat());
    let before = results();
    let overlapped = folder.denoise(&all);
    assert_eq!((one_by_one.code, overlapped.code), (1, 1), "{overlapped:?}");
    assert_eq!(told(&overlapped.stderr), told(&one_by_one.stderr));
    let told = told(&overlapped.stderr);
    let at = |text: &str| told.iter().position(|line| line.contains(text)).expect(text);
    let (first, second) = (at("beauty.0001.exr: read"), at("error: beauty.0002.exr: is empty"));
    assert!(first < second && second < at("beauty.0010.exr: color from"), "{told:?}");
    assert!(results() == before);
}

#[test]
fn frames_are_chosen_by_ranges_and_go_into_a_folder_under_their_names() {
    let folder = animation();
    folder.denoise(&["beauty.####.exr", "clean", "--frames", "1-10x9", "-q"]).assert_done();
    assert_eq!(folder.names_in("clean"), ["beauty.0001.exr", "beauty.0010.exr"]);
}

#[test]
fn several_files_and_patterns_go_into_a_folder_and_keep_their_formats() {
    let folder = animation();
    let picture = image::RgbImage::from_fn(20, 20, |x, y| image::Rgb([(x * y % 256) as u8; 3]));
    picture.save(folder.path("a.png")).unwrap();
    picture.save(folder.path("b.jpg")).unwrap();
    folder.denoise(&["a.png", "b.jpg", "beauty.00[0-9]?.exr", "clean/", "-q"]).assert_done();
    let names = ["a.png", "b.jpg", "beauty.0001.exr", "beauty.0002.exr", "beauty.0010.exr"];
    assert_eq!(folder.names_in("clean"), names);
    let written = image::ImageReader::open(folder.path("clean/b.jpg")).unwrap();
    let written = written.with_guessed_format().unwrap();
    assert_eq!(written.format(), Some(image::ImageFormat::Jpeg));
}

#[test]
fn a_picture_that_fails_is_reported_and_the_batch_continues() {
    let folder = animation();
    fs::write(folder.path("beauty.0002.exr"), "").unwrap();
    let run = folder.denoise(&["beauty.#.exr", "beauty.####.exr", "clean", "-q"]);
    run.assert_failed(1, &["beauty.#.exr: matches no file"]);
    let run = folder.denoise(&["beauty.####.exr", "clean", "-q"]);
    assert_eq!((run.code, run.stdout.as_str()), (1, ""));
    let lines: Vec<_> = run.stderr.lines().collect();
    let expected =
        ["wgdenoise: error: beauty.0002.exr: is empty", "wgdenoise: error: 1 of 3 images failed"];
    assert_eq!(lines, expected);
    assert_eq!(folder.names_in("clean"), ["beauty.0001.exr", "beauty.0010.exr"]);
    let run = folder.denoise(&["beauty.####.exr", "clean", "--force"]);
    assert!(run.stderr.contains("wgdenoise: wrote 2 of 3 images in "), "{run:?}");
}

#[test]
fn albedo_and_normals_may_be_sequences_too() {
    let folder = animation();
    for frame in ["01", "10"] {
        fs::copy(data("mitsuba_like.exr"), folder.path(&format!("aux.{frame}.exr"))).unwrap();
    }
    fs::copy(data("karma_like.exr"), folder.path("beauty.0001.exr")).unwrap();
    let args = ["beauty.####.exr", "clean", "--albedo", "aux.##.exr", "--frames"];
    folder
        .denoise(&[&args[..], &["1,2"]].concat())
        .assert_failed(1, &["aux.##.exr: frame 2 is missing"]);
    let run = folder.denoise(&[&args[..], &["1,10", "-v"]].concat());
    run.assert_done();
    for file in ["aux.01.exr", "aux.10.exr"] {
        assert!(run.stderr.contains(&format!("albedo from the file {file}")), "{run:?}");
    }
}

/// The folder `clean` must stay empty.
#[test]
fn what_cannot_be_done_in_whole_is_refused_before_the_first_image() {
    let folder = animation();
    fs::create_dir(folder.path("other")).unwrap();
    fs::copy(data("plain_rgb.exr"), folder.path("other/beauty.0001.exr")).unwrap();
    fs::write(folder.path("notes.txt"), "").unwrap();
    let (one, all) = ("beauty.0001.exr", "beauty.####.exr");
    for (args, code, words) in [
        (&[all, "clean", "--frames", "1-4,9-12"][..], 1, "frames 3-4,9,11-12 are missing"),
        (&["none.####.exr", "clean"], 1, "none.####.exr: matches no file"),
        (&["none/x.#.exr", "clean"], 1, "none/x.#.exr: its folder cannot be read"),
        (&["no*.exr", "clean"], 1, "no*.exr: matches no file"),
        (&["[.exr", "clean"], 2, "[.exr: is not a valid pattern"),
        (&[one, "nowhere.exr", "clean"], 1, "nowhere.exr: cannot be read"),
        (&[one, "nowhere.exr", "missing"], 1, "nowhere.exr: cannot be read"),
        (&["no*.exr", one, "missing"], 1, "no*.exr: matches no file"),
        (&[all, one, "missing", "--frames", "3"], 1, "frame 3 is missing"),
        (&[one, "other", "clean"], 1, "other: is a folder"),
        (&["notes.txt", one, "clean"], 2, "clean/notes.txt: cannot be written: its name must"),
        (&[all, "clean.exr"], 2, "clean.exr: needs a place for the frame number as IN has"),
        (&[one, "clean.####.exr"], 2, "clean.####.exr: has a place for a frame number"),
        (&[all, one, "clean.####.exr"], 2, "needs exactly one IN that has one too"),
        (&["#.#.exr", "clean"], 2, "#.#.exr: has two places"),
        (
            &[one, "clean", "--frames", "1"],
            2,
            "--frames needs an IN with a place for the frame number",
        ),
        (&[one, "missing/"], 1, "missing/: the results need a folder"),
        (&[one, "beauty.0002.exr", "missing"], 1, "missing: the results need a folder"),
        (&["*.exr", "missing.exr"], 1, "give --parents to create it"),
        (&[one, "other/beauty.0001.exr", "clean"], 1, "is the output of both"),
        (&[all, "missing/c.####.exr"], 1, "the folder missing does not exist"),
    ] {
        folder.denoise(args).assert_failed(code, &[words]);
    }
    assert!(folder.names_in("clean").is_empty());
}

#[test]
fn outputs_that_exist_are_kept_unless_forced_and_inputs_always() {
    let folder = animation();
    fs::write(folder.path("clean/beauty.0010.exr"), "old").unwrap();
    let all = "beauty.####.exr";
    folder
        .denoise(&[all, "clean"])
        .assert_failed(1, &["clean/beauty.0010.exr: already exists; give --force"]);
    assert_eq!(folder.names_in("clean"), ["beauty.0010.exr"]);
    for out in [all, "./beauty.%04d.exr", ".", "clean/../beauty.####.exr"] {
        folder.denoise(&[all, out, "--force"]).assert_failed(1, &["is also the input beauty.0001"]);
    }
    let through_new = "new/../beauty.####.exr";
    folder
        .denoise(&[all, through_new, "--parents", "--force"])
        .assert_failed(1, &["is also the input beauty.0001"]);
    assert!(!folder.path("new").exists());
    #[cfg(unix)]
    {
        let link = folder.path("clean/beauty.0002.exr");
        std::os::unix::fs::symlink("../beauty.0010.exr", &link).unwrap();
        let refused = &["clean/beauty.0002.exr: is also the input beauty.0010.exr"];
        folder.denoise(&[all, "clean", "--force"]).assert_failed(1, refused);
        fs::remove_file(&link).unwrap();
        fs::hard_link(folder.path("beauty.0001.exr"), &link).unwrap();
        folder
            .denoise(&[all, "clean", "--force"])
            .assert_failed(1, &["also the input beauty.0001"]);
        fs::remove_file(&link).unwrap();
    }
    folder.denoise(&[all, "clean", "--force", "-q", "--frames", "10"]).assert_done();
    assert_ne!(fs::read(folder.path("clean/beauty.0010.exr")).unwrap(), b"old");
    assert_eq!(folder.names_in("clean"), ["beauty.0010.exr"]);
}

#[test]
fn a_batch_is_denoised_in_place_unless_another_image_reads_what_is_replaced() {
    let folder = animation();
    let all = ["beauty.####.exr", "."];
    folder.denoise(&all).assert_failed(1, &["is also the input beauty.0001.exr", "--in-place"]);
    let names = ["beauty.0001.exr", "beauty.0002.exr", "beauty.0010.exr"];
    let before = names.map(|name| fs::read(folder.path(name)).unwrap());
    let shared = ["beauty.0001.exr", "beauty.0002.exr", ".", "--albedo", "beauty.0001.exr"];
    let run = folder.denoise(&[&shared[..], &["--in-place", "--force"]].concat());
    run.assert_failed(1, &["beauty.0001.exr: is also the input"]);
    assert!(!run.stderr.contains("or --in-place"), "{run:?}");
    assert!(names.map(|name| fs::read(folder.path(name)).unwrap()) == before);

    folder.denoise(&["beauty.####.exr", "clean", "-q"]).assert_done();
    let clean = names.map(|name| fs::read(folder.path("clean").join(name)).unwrap());
    for inputs in [&all[..], &all[..1], &names, &["beauty*.exr"]] {
        names
            .iter()
            .zip(&before)
            .for_each(|(name, old)| fs::write(folder.path(name), old).unwrap());
        folder.denoise(&[inputs, &["--in-place", "-q"]].concat()).assert_done();
        assert!(names.map(|name| fs::read(folder.path(name)).unwrap()) == clean, "{inputs:?}");
    }
}

#[test]
fn images_in_place_are_checked_as_others_are() {
    let folder = animation();
    fs::hard_link(folder.path("beauty.0001.exr"), folder.path("same.exr")).unwrap();
    fs::write(folder.path("notes.txt"), "notes").unwrap();
    let before = folder.names().len();
    let run = |files: &[&str]| folder.denoise(&[files, &["--in-place"]].concat());
    run(&["nowhere.exr"]).assert_failed(1, &["nowhere.exr: cannot be read"]);
    run(&["*.exr"]).assert_failed(1, &["is also the input"]);
    run(&["beauty.0002.exr", "notes.txt"]).assert_failed(2, &["notes.txt: ", "must end in .exr"]);
    assert_eq!(fs::read(folder.path("notes.txt")).unwrap(), b"notes");
    fs::copy(folder.path("beauty.0002.exr"), folder.path("named.png")).unwrap();
    run(&["named.png"]).assert_failed(1, &["named.png: is EXR, but its name means PNG"]);
    fs::remove_file(folder.path("named.png")).unwrap();
    assert_eq!(folder.names().len(), before);
}
