//! Names of files and frames: negative and fractional frames, `#` and `%`, and non-Unicode names.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::{OsStrExt, OsStringExt};

use crate::support::{Folder, Run, WEIGHTS, data};

/// A folder with one image under several names in `in`, and an empty folder `out`.
fn sequence(names: &[&str]) -> Folder {
    let folder = Folder::new();
    for inner in ["in", "out"] {
        fs::create_dir(folder.path(inner)).unwrap();
    }
    for name in names {
        fs::copy(data("plain_rgb.exr"), folder.path("in").join(name)).unwrap();
    }
    folder
}

/// The names in `out`, sorted.
fn written(folder: &Folder) -> Vec<OsString> {
    let entries = fs::read_dir(folder.path("out")).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
}

#[test]
fn frames_below_zero_are_frames() {
    let folder = sequence(&["b.-0002.exr", "b.-0001.exr", "b.0000.exr", "b.0001.exr"]);
    folder.denoise(&["in/b.####.exr", "out", "-q"]).assert_done();
    assert_eq!(written(&folder), ["b.-0001.exr", "b.-0002.exr", "b.0000.exr", "b.0001.exr"]);
    for (frames, names) in [
        (&["--frames", "-2-0"][..], &["c.-001.exr", "c.-002.exr", "c.0000.exr"][..]),
        (&["--frames=-2--1"], &["c.-001.exr", "c.-002.exr"]),
    ] {
        fs::remove_dir_all(folder.path("out")).unwrap();
        let args = ["in/b.####.exr", "out/c.%04d.exr", "--parents", "-q"];
        folder.denoise(&[&args[..], frames].concat()).assert_done();
        assert_eq!(written(&folder), names);
    }
    let run = folder.denoise(&["in/b.####.exr", "out", "--frames", "-9--8,1"]);
    run.assert_failed(1, &["frames -9--8 are missing"]);
}

/// C and Python pad numbers this way.
#[test]
fn a_sign_may_count_as_a_digit_of_an_input() {
    let folder = sequence(&["b.-002.exr", "b.0001.exr"]);
    for name in ["-002", "0001"] {
        let aux = folder.path("in").join(format!("aux.{name}.exr"));
        fs::copy(data("mitsuba_like.exr"), aux).unwrap();
        fs::copy(data("karma_like.exr"), folder.path("in").join(format!("b.{name}.exr"))).unwrap();
    }
    let args = ["in/b.####.exr", "out/c.####.exr", "--albedo", "in/aux.####.exr", "-v"];
    let run = folder.denoise(&args);
    run.assert_done();
    assert!(run.stderr.contains("albedo from the file in/aux.-002.exr"), "{run:?}");
    assert_eq!(written(&folder), ["c.-0002.exr", "c.0001.exr"]);
}

#[test]
fn files_between_frames_are_left_out_by_name_or_taken_by_a_pattern_of_their_own() {
    let folder = sequence(&["b.0001.exr", "b.0001.25.exr", "b.0001.5.exr", "b.2.exr"]);
    let run = folder.denoise(&["in/b.####.exr", "out"]);
    run.assert_done();
    let expected = "wgdenoise: in/b.####.exr: left out b.0001.25.exr, b.0001.5.exr, b.2.exr: ";
    assert!(run.stderr.starts_with(expected), "{run:?}");
    assert_eq!(written(&folder), ["b.0001.exr"]);
    let run = folder.denoise(&["in/b.####.exr", "out", "--frames", "1", "--force"]);
    assert!(!run.stderr.contains("left out"), "{run:?}");
    folder.denoise(&["in/b.####.25.exr", "out/c.####.25.exr", "-q"]).assert_done();
    assert_eq!(written(&folder), ["b.0001.exr", "c.0001.25.exr"]);
    folder.denoise(&["in/b.######.exr", "out"]).assert_failed(
        1,
        &["in/b.######.exr: matches no file, but b.0001.25.exr, ", "number of digits"],
    );
}

#[test]
fn an_output_may_have_a_plain_hash_or_percent_in_its_name() {
    let folder = sequence(&["in.exr", "b.0007.exr"]);
    for (out, name) in [
        ("take#2.exr", "take#2.exr"),
        ("100%.exr", "100%.exr"),
        ("100%done.exr", "100%done.exr"),
        ("a#b#c.exr", "a#b#c.exr"),
        ("take[#][#]2[%]04d.exr", "take##2%04d.exr"),
    ] {
        folder.denoise(&["in/in.exr", &format!("out/{out}"), "-q"]).assert_done();
        assert_eq!(written(&folder), [name]);
        fs::remove_file(folder.path("out").join(name)).unwrap();
    }
    let refused = "has a place for a frame number, which needs exactly one IN that has one too; \
                   write [#] for a plain #";
    for out in ["out/c.####.exr", "out/c.%04d.exr"] {
        folder.denoise(&["in/in.exr", out]).assert_failed(2, &[refused]);
    }
    folder.denoise(&["in/b.####.exr", "out/take[#]2.####.exr", "-q"]).assert_done();
    assert_eq!(written(&folder), ["take#2.0007.exr"]);
    let two = ["in/b.####.exr", "out/take#2.####.exr"];
    folder.denoise(&two).assert_failed(2, &["two places", "write [#] for a plain #"]);
}

#[test]
fn any_name_that_the_system_takes_can_be_read_and_written() {
    let folder = sequence(&[]);
    let path = |name: &[u8]| folder.path("in").join(OsStr::from_bytes(name));
    for (file, name) in [
        ("karma_like.exr", &b"caf\xe9.01.exr"[..]),
        ("mitsuba_like.exr", b"\xff.01.exr"),
        ("mitsuba_like.exr", b"\xff.exr"),
    ] {
        fs::copy(data(file), path(name)).unwrap();
    }
    let arg = |bytes: &[u8]| OsString::from_vec(bytes.to_vec());
    let weights = ["--weights", WEIGHTS].map(OsString::from);
    let run = |args: &[&[u8]]| {
        let args = args.iter().map(|bytes| arg(bytes)).chain(weights.clone());
        Run::of(&folder.command(&[]).args(args).output().unwrap())
    };
    let aux = run(&[b"in/caf\xe9.01.exr", b"out/\xe9.exr", b"-v", b"--albedo", b"in/\xff.exr"]);
    assert!(
        aux.code == 0 && aux.stderr.contains("albedo from the file in/\u{fffd}.exr"),
        "{aux:?}"
    );
    run(&[b"in/caf\xe9.##.exr", b"out/\xe8.#.exr", b"-q", b"--normal", b"in/\xff.##.exr"])
        .assert_done();
    assert_eq!(written(&folder), [arg(b"\xe8.1.exr"), arg(b"\xe9.exr")]);
    let both = "no layer `\u{fffd}`";
    run(&[b"in/caf\xe9.01.exr", b"out/o.exr", b"--normal", b"\xff"]).assert_failed(1, &[both]);
}
