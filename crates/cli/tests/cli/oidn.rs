//! Weights shaped like Open Image Denoise's, from files and folders: small ones with random values,
//! made by `training/make_oidn_fixtures.py`.

use std::fs;
use std::path::Path;

use crate::support::{Folder, Run};

#[path = "oidn_refused.rs"]
mod refused;

const WITH_ALL: &str = "blender4_single_part.exr";

/// Copies a fixture into the folder `weights` under this name.
fn put(folder: &Folder, fixture: &str, name: &str) {
    let from =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/oidn").join(fixture);
    fs::create_dir_all(folder.path("weights")).unwrap();
    fs::copy(from, folder.path("weights").join(name)).unwrap();
}

/// A folder with weights and two images.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.copy(WITH_ALL);
    folder.copy("plain_rgb.exr");
    put(&folder, "rt_hdr_alb_nrm.tza", "rt_hdr_alb_nrm.tza");
    folder
}

impl Folder {
    fn png(&self, name: &str) {
        let value = |x, y| image::Rgb([(7 * x * y % 256) as u8; 3]);
        image::RgbImage::from_fn(20, 20, value).save(self.path(name)).unwrap();
    }
}

#[track_caller]
fn says(run: &Run, words: &[&str]) {
    run.assert_done();
    for word in words {
        assert!(run.stderr.contains(word), "no `{word}` in {run:?}");
    }
}

#[test]
fn a_converted_file_does_what_the_original_does() {
    let folder = folder();
    let [tza, converted] = ["weights/rt_hdr_alb_nrm.tza", "c.safetensors"];
    says(&folder.run(&["convert", tza, converted]), &["`rt_hdr_alb_nrm`", "transfer function pu"]);
    folder
        .run(&["convert", tza, converted])
        .assert_failed(1, &["c.safetensors: already exists", "--force"]);
    folder.run(&["convert", tza, converted, "--force"]).assert_done();
    let outputs = [(tza, "a.exr"), (converted, "b.exr")].map(|(weights, out)| {
        folder.run(&[WITH_ALL, out, "-q", "--weights", weights]).assert_done();
        fs::read(folder.path(out)).unwrap()
    });
    assert!(outputs[0] == outputs[1], "the two pictures differ");
}

#[test]
fn the_file_for_the_layers_of_the_image_is_picked_from_a_folder() {
    let folder = folder();
    let run = |picture, out| folder.run(&[picture, out, "--weights", "weights"]);
    says(&run(WITH_ALL, "a.exr"), &["weights: weights/rt_hdr_alb_nrm.tza"]);
    let denoise = ["plain_rgb.exr", "b.exr", "-q", "--weights"];
    let failed = |weights| folder.run(&[&denoise[..], &[weights]].concat());
    failed("weights").assert_failed(1, &["weights: has no rt_hdr.tza, nor", "docs/weights.md"]);
    failed("weights/rt_hdr_alb_nrm.tza")
        .assert_failed(1, &["needs color, albedo, normal, but color was given", "rt_hdr.tza"]);
    put(&folder, "rt_alb.tza", "rt_hdr_small.tza");
    let fast =
        folder.run(&[&denoise[..2], &["--weights", "weights", "--quality", "fast"]].concat());
    says(&fast, &["weights: weights/rt_hdr_small.tza"]);
}

#[test]
fn a_png_gets_weights_for_display_colors() {
    let folder = folder();
    put(&folder, "rt_alb.tza", "rt_ldr.tza");
    put(&folder, "rt_alb.tza", "rt_hdr.tza");
    folder.png("in.png");
    let run = folder.run(&["in.png", "out.png", "--weights", "weights"]);
    says(&run, &["weights: weights/rt_ldr.tza", "wrote out.png in "]);
    assert_eq!(run.stderr.lines().count(), 2, "{run:?}");
}

#[test]
fn albedo_and_normal_are_denoised_first_if_asked() {
    let folder = folder();
    let prefiltered =
        |out| folder.run(&[WITH_ALL, out, "-q", "--weights", "weights", "--prefilter"]);
    prefiltered("a.exr").assert_failed(1, &["weights: has no rt_hdr_calb_cnrm.tza"]);
    put(&folder, "rt_hdr_alb_nrm.tza", "rt_hdr_calb_cnrm.tza");
    prefiltered("a.exr").assert_failed(1, &["weights: has no rt_alb.tza"]);
    for name in ["rt_alb.tza", "rt_nrm.tza"] {
        put(&folder, "rt_alb.tza", name);
    }
    let run = folder.run(&[WITH_ALL, "a.exr", "--weights", "weights", "--prefilter"]);
    says(&run, &["denoised first, by rt_alb and rt_nrm", "weights/rt_hdr_calb_cnrm.tza"]);
    let clean = "weights/rt_hdr_calb_cnrm.tza";
    folder.run(&[WITH_ALL, "b.exr", "-q", "--weights", clean]).assert_done();
    let [with, without] = ["a.exr", "b.exr"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(with != without, "the prefilter changed nothing");
    let args = ["plain_rgb.exr", "c.exr", "-q", "--weights", "weights", "--prefilter"];
    folder.run(&args).assert_failed(1, &["--prefilter needs albedo and normal", "has color"]);
}

#[test]
fn bench_reports_what_the_weights_read() {
    let folder = folder();
    put(&folder, "rt_alb.tza", "rt_hdr.tza");
    let bench = |weights: &str| {
        let size = ["bench", "--width", "32", "--height", "32", "--runs", "1"];
        folder.run(&[&size[..], &["--weights", weights]].concat())
    };
    for (weights, inputs) in [("rt_hdr", "color"), ("rt_hdr_alb_nrm", "color, albedo, normal")] {
        let run = bench(&format!("weights/{weights}.tza"));
        assert!(run.stdout.contains(&format!("kMAC per pixel, {inputs}\n")), "{run:?}");
    }
    fs::create_dir(folder.path("none")).unwrap();
    let words = "none: has none of rt_hdr_alb_nrm.tza, rt_hdr_alb.tza, rt_hdr.tza, nor a converted";
    bench("none").assert_failed(1, &[words]);
}

#[test]
fn each_of_several_images_gets_the_weights_for_its_layers() {
    let folder = folder();
    put(&folder, "rt_alb.tza", "rt_hdr.tza");
    for (name, from) in [("a.exr", WITH_ALL), ("b.exr", WITH_ALL), ("c.exr", "plain_rgb.exr")] {
        fs::copy(folder.path(from), folder.path(name)).unwrap();
    }
    fs::create_dir(folder.path("clean")).unwrap();
    let run = folder.run(&["[abc].exr", "clean", "-v", "--verify", "--weights", "weights"]);
    says(&run, &["a.exr: weights: weights/rt_hdr_alb_nrm.tza", "c.exr: weights: weights/rt_hdr."]);
    assert_eq!(run.stderr.matches("prepared in").count(), 2, "{run:?}");
    folder.run(&["c.exr", "alone.exr", "-q", "--weights", "weights/rt_hdr.tza"]).assert_done();
    let [alone, among] = ["alone.exr", "clean/c.exr"].map(|name| fs::read(folder.path(name)));
    assert!(alone.unwrap() == among.unwrap(), "the order of pictures changes a result");
}
