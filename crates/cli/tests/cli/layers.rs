//! Further layers of light, denoised with the color.

use exr::prelude::FlatSamples;

use crate::support::{Folder, data, read_exr, take};

const GROUPS: [&str; 3] = ["Combined_key", "Combined_lamp", "Combined_sky"];

/// A layer's red, green and blue values, channel by channel.
fn layer(path: &std::path::Path, name: &str) -> Vec<f32> {
    let mut file = read_exr(path);
    let values = ["R", "G", "B"].map(|c| take(&mut file, 0, &format!("ViewLayer.{name}.{c}")));
    let floats = |samples: &FlatSamples| samples.values_as_f32().collect::<Vec<_>>();
    values.iter().flat_map(floats).collect()
}

/// The largest difference between the image and the sum of its light groups, relative to the pixel
/// or to the image's mean, whichever is larger.
fn off(path: &std::path::Path) -> f32 {
    let picture = layer(path, "Combined");
    let groups = GROUPS.map(|group| layer(path, group));
    let mean = picture.iter().sum::<f32>() / picture.len() as f32;
    let sum = |i: usize| groups.iter().map(|group| group[i]).sum::<f32>();
    let off = picture.iter().enumerate().map(|(i, v)| (v - sum(i)).abs() / v.abs().max(mean));
    off.fold(0.0, f32::max)
}

/// The color is scaled by settled alpha, which the reference must do too.
#[test]
fn color_that_was_denoised_with_its_alpha_is_verified() {
    let folder = Folder::new();
    folder.copy("light_groups.exr");
    let args = ["light_groups.exr", "out.exr", "--verify", "--precision", "f32"];
    let run = folder.run(&[&args[..], &["--quality", "fast", "--alpha", "denoise"]].concat());
    run.assert_done();
    assert!(run.stderr.contains("verified 16×16 pixels"), "{run:?}");
}

/// A Cycles render, unmodified.
#[test]
fn denoised_light_groups_add_up_to_the_denoised_picture() {
    let noisy = data("light_groups.exr");
    assert!(off(&noisy) < 1e-6, "the renderer's own groups are off by {}", off(&noisy));
    for (quality, precision) in [("fast", "f16"), ("balanced", "f32"), ("high", "f16")] {
        let folder = Folder::new();
        let input = folder.copy("light_groups.exr");
        let settings = ["--quality", quality, "--precision", precision];
        let args = ["light_groups.exr", "out.exr", "--layers", "auto"];
        let run = folder.run(&[&args[..], &settings].concat());
        run.assert_done();
        let output = folder.path("out.exr");
        assert!(off(&output) < 1e-5, "{quality} {precision}: off by {}", off(&output));
        for name in GROUPS.into_iter().chain(["Combined"]) {
            let [before, after] = [&input, &output].map(|path| layer(path, name));
            let changed = before.iter().zip(&after).filter(|(a, b)| a != b).count();
            assert!(changed > before.len() / 2, "{name}: {changed} values changed");
        }
    }
}
