//! Errors and notices about Open Image Denoise's weights.

use std::fs;

use super::{WITH_ALL, folder, put, says};

#[test]
fn a_file_that_cannot_be_converted_is_named_and_nothing_written() {
    let folder = folder();
    fs::copy(folder.path("weights/rt_hdr_alb_nrm.tza"), folder.path("my.tza")).unwrap();
    folder.run(&["convert", "my.tza", "c.safetensors"]).assert_failed(1, &["my.tza: ", "`my`"]);
    let convert = |input| folder.run(&["convert", input, "c.safetensors"]);
    convert("plain_rgb.exr").assert_failed(1, &["plain_rgb.exr: weights: "]);
    convert("nowhere.tza").assert_failed(1, &["nowhere.tza: cannot be read"]);
    assert!(!folder.path("c.safetensors").exists());
}

#[test]
fn a_converted_file_never_replaces_an_original_nor_gets_such_a_name() {
    let folder = folder();
    let tza = "weights/rt_hdr_alb_nrm.tza";
    let whole = fs::read(folder.path(tza)).unwrap();
    fs::hard_link(folder.path(tza), folder.path("link.safetensors")).unwrap();
    for output in [tza, "link.safetensors"] {
        folder.run(&["convert", tza, output, "--force"]).assert_failed(1, &["is also the input"]);
        assert!(fs::read(folder.path(output)).unwrap() == whole, "{output}");
    }
    folder.run(&["convert", tza, "new.tza"]).assert_failed(1, &["new.tza: ", ".safetensors"]);
    assert!(!folder.path("new.tza").exists());
}

#[test]
fn a_file_is_judged_by_its_name_before_its_content() {
    let folder = folder();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a";
    fs::write(folder.path("rt_hdr.tza"), pointer).unwrap();
    // A safetensors file with a 16855-byte header starts like a TZA file.
    let begin = [&16855_u64.to_le_bytes()[..], b"{\"__metadata__\":{}}"].concat();
    fs::write(folder.path("w.safetensors"), begin).unwrap();
    let words = "rt_hdr.tza: weights: TZA file: the signature is missing; get";
    // Two images need the file, but the error is reported once.
    fs::create_dir(folder.path("clean")).unwrap();
    let run =
        |weights| folder.run(&["plain_rgb.exr", WITH_ALL, "clean", "-q", "--weights", weights]);
    run("rt_hdr.tza").assert_failed(1, &[words, "Git LFS pointer"]);
    run("w.safetensors").assert_failed(1, &["w.safetensors: weights: not a whole safetensors"]);
    folder.run(&["convert", "rt_hdr.tza", "c.safetensors"]).assert_failed(1, &[words]);
}

#[test]
fn png_and_jpeg_are_refused_for_values_of_both_signs() {
    let folder = folder();
    put(&folder, "rt_alb.tza", "rt_nrm.tza");
    folder.png("in.png");
    let run = |from, to| folder.run(&[from, to, "-q", "--weights", "weights/rt_nrm.tza"]);
    run("in.png", "out.exr").assert_failed(1, &["in.png: PNG and JPEG", "`rt_nrm`", "use EXR"]);
    run(WITH_ALL, "look.png").assert_failed(1, &["look.png: PNG and JPEG", "`rt_nrm`", "use EXR"]);
    run(WITH_ALL, "look.JPG").assert_failed(1, &["look.JPG: PNG and JPEG"]);
    assert!(["out.exr", "look.png", "look.JPG"].iter().all(|name| !folder.path(name).exists()));
    run(WITH_ALL, "out.exr").assert_done();
}

#[test]
fn a_named_file_for_something_else_gives_one_notice() {
    let folder = folder();
    folder.png("in.png");
    let fits = "";
    for (weights, picture, out, expected) in [
        ("rt_nrm", WITH_ALL, "n.exr", "the color is taken as normals, which the weights `rt_nrm`"),
        ("rt_alb", WITH_ALL, "a.exr", "the color is taken as albedo, which the weights `rt_alb`"),
        ("rtlightmap_dir", WITH_ALL, "d.exr", "the color is taken as directions, which the"),
        ("rt_ldr", WITH_ALL, "l.exr", "`rt_ldr` are for display colors: light above 1 is clipped"),
        ("rt_hdr", "in.png", "h.png", "`rt_hdr` are for light of any brightness, but PNG and JPEG"),
        ("rtlightmap_hdr", "in.png", "m.png", "`rtlightmap_hdr` are for light of any brightness"),
        ("rt_hdr", WITH_ALL, "f.exr", fits),
        ("rt_ldr", "in.png", "f.png", fits),
    ] {
        put(&folder, "rt_alb.tza", &format!("{weights}.tza"));
        let file = format!("weights/{weights}.tza");
        let run = folder.run(&[picture, out, "--weights", &file]);
        says(&run, &[expected]);
        let count = run.stderr.lines().filter(|line| line.contains("` are for")).count();
        assert_eq!(count, usize::from(expected != fits), "{run:?}");
        let quiet = folder.run(&[picture, out, "--weights", &file, "-q", "--force"]);
        assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""), "{quiet:?}");
    }
}

#[test]
fn flags_that_need_a_folder_are_refused_with_a_file_before_any_work() {
    let folder = folder();
    let file = ["--weights", "weights/rt_hdr_alb_nrm.tza"];
    let run = |args: &[&str]| folder.run(&[args, &file].concat());
    let denoise = ["nowhere.exr", "out.exr"];
    let words = ["--quality", "names weights/rt_hdr_alb_nrm.tza, which is not a folder"];
    run(&[&denoise[..], &["--quality", "fast"]].concat()).assert_failed(2, &words);
    run(&["bench", "--quality", "fast"]).assert_failed(2, &words);
    let words =
        ["--prefilter needs a folder", "names weights/rt_hdr_alb_nrm.tza, which is not a folder"];
    run(&[&denoise[..], &["--prefilter"]].concat()).assert_failed(2, &words);
}

#[test]
fn damaged_weights_of_one_image_do_not_stop_the_batch() {
    let folder = folder();
    put(&folder, "rt_alb.tza", "rt_ldr.tza");
    let file = folder.path("weights/rt_ldr.tza");
    let whole = fs::read(&file).unwrap();
    fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    fs::create_dir(folder.path("out")).unwrap();
    folder.png("a.png");
    fs::copy(folder.path(WITH_ALL), folder.path("b.exr")).unwrap();
    let run = folder.run(&["a.png", "b.exr", "out/", "-q", "--weights", "weights"]);
    let lines: Vec<_> = run.stderr.lines().collect();
    assert!(run.code == 1 && lines.len() == 2, "{run:?}");
    let words = "error: a.png: weights/rt_ldr.tza: weights: not a whole TZA file: ";
    assert!(lines[0].contains(words), "{run:?}");
    assert!(lines[1].ends_with("1 of 2 images failed"), "{run:?}");
    assert!(folder.path("out/b.exr").exists() && !folder.path("out/a.png").exists());
}

#[test]
fn an_image_that_no_weights_fit_does_not_stop_the_batch() {
    let folder = folder();
    fs::create_dir(folder.path("clean")).unwrap();
    let run = folder.run(&["plain_rgb.exr", WITH_ALL, "clean", "-q", "--weights", "weights"]);
    let lines: Vec<_> = run.stderr.lines().collect();
    assert!(run.code == 1 && lines.len() == 2, "{run:?}");
    assert!(lines[0].contains("error: plain_rgb.exr: weights: has no rt_hdr.tza"), "{run:?}");
    assert!(lines[1].ends_with("1 of 2 images failed"), "{run:?}");
    assert!(folder.path("clean").join(WITH_ALL).exists());
}
