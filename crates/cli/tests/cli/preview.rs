//! Previews of layers without denoising, and the exposure of PNG and JPEG outputs.

use std::fs;

use exr::prelude::*;

use crate::support::{Folder, WEIGHTS};

const SIZE: (usize, usize) = (5, 3);

/// A color, a normal, a depth and two channels of motion, each constant.
fn layers() -> Folder {
    let folder = Folder::new();
    let values = [
        ("R", 0.25),
        ("G", 0.125),
        ("B", 4.0),
        ("A", 1.0),
        ("N.X", 0.5),
        ("N.Y", -0.5),
        ("N.Z", 1.0),
        ("depth.Z", 0.5),
        ("motion.X", 1.0),
        ("motion.Y", 0.5),
    ];
    let plane = |value| FlatSamples::F32(vec![value; SIZE.0 * SIZE.1]);
    let list = values.map(|(name, value)| AnyChannel::new(name, plane(value)));
    let channels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new(SIZE, LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(folder.path("in.exr")).unwrap();
    folder
}

/// 8-bit sRGB (IEC 61966-2-1), written independently.
fn srgb(linear: f64) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

#[test]
fn every_layer_and_channel_is_shown_clipped_and_srgb_encoded() {
    let folder = layers();
    for (args, shown) in [
        (&[][..], [0.25, 0.125, 1.0]),
        (&["--exposure", "1"], [0.5, 0.25, 1.0]),
        (&["--exposure", "-3"], [0.25 / 8.0, 0.125 / 8.0, 0.5]),
        (&["--layer", "N"], [0.5, 0.0, 1.0]),
        (&["--layer", "depth"], [0.5, 0.5, 0.5]),
        (&["--layer", "depth.Z", "--exposure", "-1"], [0.25, 0.25, 0.25]),
        (&["--layer", "A"], [1.0, 1.0, 1.0]),
        (&["--layer", "motion"], [1.0, 0.5, 0.0]),
    ] {
        let run = folder.run(&[&["preview", "in.exr", "look.png", "--force"], args].concat());
        run.assert_done();
        assert!(run.stderr.starts_with("wgdenoise: wrote `"), "{run:?}");
        let look = image::open(folder.path("look.png")).unwrap();
        assert_eq!((look.width(), look.height(), look.color()), (5, 3, image::ColorType::Rgb8));
        let pixels = look.to_rgb8();
        assert!(pixels.pixels().all(|p| p.0 == shown.map(srgb)), "{args:?}: {:?}", pixels[(0, 0)]);
    }
}

#[test]
fn what_cannot_be_previewed_is_one_sentence_and_leaves_nothing_behind() {
    let folder = layers();
    fs::write(folder.path("old.png"), "old").unwrap();
    let preview = |args: &[&str]| folder.run(&[&["preview"], args].concat());
    for name in ["look.exr", "look.tif", "look", "new/look"] {
        let says = format!("{name}: cannot be written: a preview is a .png, .jpg or .jpeg file");
        preview(&["in.exr", name, "--parents"]).assert_failed(2, &[&says]);
    }
    preview(&["in.exr", "in.exr", "--force"]).assert_failed(1, &["is also the input"]);
    preview(&["in.exr", "old.png"]).assert_failed(1, &["already exists", "--force"]);
    preview(&["nowhere.exr", "look.png"]).assert_failed(1, &["nowhere.exr: cannot be read"]);
    preview(&["in.exr", "look.png", "--layer", "M"])
        .assert_failed(1, &["no layer `M`", "`RGB`, `N`, `depth`, `motion`"]);
    let two = preview(&["in.exr", "look.png", "--max-pixels", "14"]);
    two.assert_failed(1, &["claims 5×3 pixels", "--max-pixels"]);
    assert_eq!(folder.names(), ["in.exr", "old.png"]);
    assert_eq!(fs::read(folder.path("old.png")).unwrap(), b"old");
}

#[test]
fn several_beauty_layers_are_chosen_among_with_layer() {
    let folder = Folder::new();
    let list = ["x.R", "x.G", "x.B", "y.R", "y.G", "y.B"]
        .map(|name| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 15])));
    let channels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new(SIZE, LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(folder.path("in.exr")).unwrap();
    let run = folder.run(&["preview", "in.exr", "look.png"]);
    run.assert_failed(1, &["2 layers that could be the color", "name one with --layer"]);
    let run = folder.run(&["in.exr", "look.png", "-q"]);
    run.assert_failed(1, &["2 layers that could be the color", "name one with --color"]);
    let info = folder.run(&["info", "in.exr"]);
    assert!(info.stdout.contains("cannot be denoised") && info.stdout.contains("with --color"));
}

/// The denoised PNG equals the preview of the denoised EXR at the same exposure.
#[test]
fn exposure_brightens_denoised_pngs_as_it_does_previews() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    folder.denoise(&["plain_rgb.exr", "clean.exr"]).assert_done();
    let png = |name: &str| image::open(folder.path(name)).unwrap().to_rgb8();
    for stops in ["0", "1.5", "-2"] {
        let exposure = ["--exposure", stops, "--force"];
        folder.denoise(&[&["plain_rgb.exr", "a.png"], &exposure[..]].concat()).assert_done();
        folder.run(&[&["preview", "clean.exr", "b.png"], &exposure[..]].concat()).assert_done();
        let [a, b] = ["a.png", "b.png"].map(png);
        // The EXR file rounds to half.
        let differ = a.as_raw().iter().zip(b.as_raw()).filter(|(a, b)| a.abs_diff(**b) > 1);
        assert_eq!(differ.count(), 0, "{stops}");
    }
    folder.denoise(&["plain_rgb.exr", "dark.png", "--exposure", "-2", "--force"]).assert_done();
    folder.denoise(&["plain_rgb.exr", "plain.png"]).assert_done();
    assert!(png("dark.png") != png("plain.png"));
    let args = ["plain_rgb.exr", "x.exr", "--exposure", "1", "--weights", WEIGHTS];
    folder.run(&args).assert_failed(2, &["x.exr: ", "--exposure changes PNG and JPEG only"]);
    assert!(!folder.path("x.exr").exists());
}
