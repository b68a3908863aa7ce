//! Drives the whole window without a screen: acts as a user and checks that the picture changes.
//! With `WGDENOISE_SCREENSHOTS` set to a folder, saves each picture there.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, TouchPhase, Vec2, pos2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, ImageAttributes, Layer, LayerAttributes,
    WritableImage as _,
};
use image::RgbaImage;
use wgdenoise_files::Picture;

use crate::app::Viewer;
use crate::commands;
use crate::gpu::host::configuration;
use crate::open::{Opened, Wish};
use crate::save;
use crate::state::looking::{Layout, Shown};

const SIZE: [f32; 2] = [1280.0, 800.0];

/// How long denoising the sample may take without a GPU.
const PATIENCE: Duration = Duration::from_mins(4);

mod choices;
mod input;

struct Window(Harness<'static, Viewer>);

impl Window {
    fn open(files: &[PathBuf], reference: Option<&PathBuf>) -> Self {
        let harness = Harness::builder()
            .with_size(Vec2::from(SIZE))
            .wgpu_setup(configuration().wgpu_setup)
            .build_eframe(|creation| Viewer::new(creation, files, reference).unwrap());
        Self(harness)
    }

    /// Draws frames until the condition is met.
    fn wait_for(&mut self, what: &str, is_so: impl Fn(&Viewer) -> bool) {
        let start = Instant::now();
        while !is_so(self.0.state()) {
            assert!(start.elapsed() < PATIENCE, "{what}: {:?}", self.0.state().session.message);
            std::thread::sleep(Duration::from_millis(10));
            self.0.step();
        }
        self.0.run_steps(2);
    }

    fn denoised(&mut self) {
        self.wait_for("denoised", |viewer| {
            viewer.session.denoised.is_some() && !viewer.session.is_denoising()
        });
    }

    /// The current message, once nothing is being saved.
    fn message(&mut self) -> String {
        let told = |viewer: &Viewer| viewer.session.message.clone().map(|message| message.text);
        self.wait_for("told", |v| told(v).is_some_and(|text| !text.starts_with("saving ")));
        told(self.0.state()).unwrap()
    }

    fn press(&mut self, key: Key) {
        self.press_with(Modifiers::NONE, key);
    }

    fn press_with(&mut self, held: Modifiers, key: Key) {
        self.0.key_press_modifiers(held, key);
        self.0.run_steps(3);
    }

    fn picture(&mut self, name: &str) -> RgbaImage {
        let picture = self.0.render().unwrap();
        if let Some(folder) = std::env::var_os("WGDENOISE_SCREENSHOTS") {
            picture.save(Path::new(&folder).join(name).with_extension("png")).unwrap();
        }
        picture
    }
}

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name)
}

fn noisy() -> PathBuf {
    sample("still_life_8spp.exr")
}

/// Mean difference of two window pictures over the image area, in 8-bit values.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let (columns, rows) = (0..900, 60..740);
    let apart = |x: u32, y: u32| {
        let channel = |i: usize| f64::from(a.get_pixel(x, y)[i].abs_diff(b.get_pixel(x, y)[i]));
        (channel(0) + channel(1) + channel(2)) / 3.0
    };
    let places = rows.clone().flat_map(|y| columns.clone().map(move |x| (x, y)));
    places.map(|(x, y)| apart(x, y)).sum::<f64>() / (columns.len() * rows.len()) as f64
}

#[test]
fn an_empty_window_offers_what_to_do() {
    let mut window = Window::open(&[], None);
    window.0.run_steps(3);
    window.0.get_by_label("Open…");
    window.picture("empty");
    window.press(Key::Questionmark);
    window.0.get_by_label("toggle noisy and denoised");
    window.picture("help");
    window.press(Key::Escape);
    assert!(!window.0.state().session.shows_help);
}

#[test]
fn a_file_that_is_no_image_is_one_sentence_in_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("broken.exr");
    std::fs::write(&file, "no image").unwrap();
    let mut window = Window::open(std::slice::from_ref(&file), None);
    window.wait_for("told", |viewer| viewer.session.message.is_some());
    let message = window.0.state().session.message.clone().unwrap();
    assert!(message.is_error && message.text == Opened::noisy(&file, Wish::default()).unwrap_err());
    window.0.get_by_label(&message.text);
    window.picture("broken");
}

#[test]
fn the_sample_is_opened_denoised_looked_at_and_saved() {
    let mut window = Window::open(&[noisy()], Some(&sample("still_life_reference.exr")));
    window.denoised();
    window.wait_for("compared", |viewer| {
        viewer.session.figures.is_some_and(|figures| figures.rows()[0].denoised != "…")
    });
    let denoised = window.picture("denoised");
    look(&mut window, &denoised);
    arrange(&mut window, &denoised);
    save_all(&window);
}

/// Every key shows another picture.
fn look(window: &mut Window, denoised: &RgbaImage) {
    window.press(Key::Space);
    let noisy = window.picture("noisy");
    assert!(difference(&noisy, denoised) > 4.0, "{}", difference(&noisy, denoised));
    window.press(Key::Space);
    assert_eq!(difference(&window.picture("again"), denoised), 0.0);
    let keys = [Key::Num3, Key::Num4, Key::Num5, Key::Num6];
    for (key, name) in keys.into_iter().zip(["reference", "albedo", "normal", "difference"]) {
        window.press(key);
        assert!(difference(&window.picture(name), denoised) > 1.0, "{name}");
    }
    window.press(Key::Num2);
    for (key, name) in [(Key::E, "exposed"), (Key::T, "filmic")] {
        window.press(key);
        assert!(difference(&window.picture(name), denoised) > 3.0, "{name}");
    }
    window.press(Key::T);
    window.press(Key::Num0);
    assert_eq!(difference(&window.picture("back"), denoised), 0.0);
}

/// Layouts, zoom, pan, and the value under the cursor.
fn arrange(window: &mut Window, denoised: &RgbaImage) {
    window.press(Key::S);
    let split = window.picture("split");
    assert!(difference(&split, denoised) > 2.0);
    let (from, to) = (pos2(497.0, 400.0), pos2(250.0, 400.0));
    let middle = window.0.state().session.area[0] / 2.0;
    window.0.drag_at(pos2(middle, from.y));
    window.0.step();
    window.0.hover_at(to);
    window.0.step();
    window.0.drop_at(to);
    window.0.run_steps(2);
    assert!(window.0.state().session.looking.split < 0.4, "the line was dragged");
    window.press(Key::D);
    assert_eq!(window.0.state().session.looking.layout, Layout::SideBySide);
    assert!(difference(&window.picture("side_by_side"), &split) > 2.0);
    window.press(Key::D);
    zoom(window);
    window.press(Key::F);
    window.0.remove_cursor();
    window.0.run_steps(3);
    assert_eq!(difference(&window.picture("fit"), denoised), 0.0);
}

fn zoom(window: &mut Window) {
    let before = window.0.state().session.transform.zoom();
    window.0.hover_at(pos2(500.0, 400.0));
    window.0.step();
    let pointed = window.0.state().session.pointed;
    assert!(pointed.is_some());
    window.0.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: Vec2::new(0.0, 500.0),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.0.run_steps(20);
    let session = &window.0.state().session;
    let zoom = session.transform.zoom();
    assert!(zoom > 4.0 * before, "from {before} to {zoom}");
    assert_eq!(session.pointed, pointed, "what is under the cursor stays there");
    window.picture("zoomed");
    window.press(Key::Z);
    assert_eq!(window.0.state().session.transform.zoom(), 1.0);
}

/// The saved file is what the command line would write, and the pictures are complete.
fn save_all(window: &Window) {
    let folder = tempfile::tempdir().unwrap();
    let session = &window.0.state().session;
    let path = folder.path().join("clean.exr");
    let outcome = session.denoised.as_ref().unwrap();
    let told = save::result(session.opened().unwrap(), &outcome.results, &path).unwrap();
    assert!(told.starts_with("saved "), "{told}");
    let saved = Picture::open(&path, &Default::default()).unwrap();
    let result = session.image(Shown::Denoised).unwrap();
    let mean = |image: &wgdenoise::Image| {
        let values = image.pixels().as_flattened();
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
    };
    let (found, expected) = (mean(saved.first().color()), mean(result));
    assert!((found / expected - 1.0).abs() < 1e-3, "{found}, not {expected}");
    let error = save::result(session.opened().unwrap(), &outcome.results, &noisy()).unwrap_err();
    assert!(error.contains("is the noisy image"), "{error}");
}

#[test]
fn settings_denoise_anew_and_a_comparison_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[noisy()], None);
    window.denoised();
    let balanced = window.0.state().session.image(Shown::Denoised).unwrap().clone();
    window.0.get_by_label("Fast").click();
    window.0.run_steps(2);
    assert!(window.0.state().session.is_denoising());
    window.denoised();
    let session = &window.0.state().session;
    assert_ne!(session.image(Shown::Denoised), Some(&balanced));
    window.press(Key::D);
    let path = folder.path().join("both.png");
    commands::save_comparison(&mut window.0.state_mut().session, &path);
    assert!(window.message().starts_with("saved "));
    let size = window.0.state().session.opened().unwrap().size();
    assert_eq!(image::image_dimensions(&path).unwrap(), (2 * size[0], size[1]));
}

#[test]
fn work_can_be_canceled_and_its_result_is_not_shown() {
    let mut window = Window::open(&[noisy()], None);
    window.wait_for("started", |viewer| viewer.session.is_denoising());
    window.press(Key::Escape);
    let session = &window.0.state().session;
    assert!(!session.is_denoising() && session.denoised.is_none());
    window.0.get_by_label("canceled");
    window.0.get_by_label("Denoise now").click();
    window.0.run_steps(2);
    window.denoised();
    window.0.event(Event::Copy);
    window.wait_for("copied", |viewer| {
        viewer.session.message.as_ref().is_some_and(|message| message.text.starts_with("copied"))
    });
}

#[test]
fn arrow_keys_lead_through_frames_and_a_rewritten_file_is_denoised_anew() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |i: u32| folder.path().join(format!("f.{i:04}.png"));
    let write = |i: u32, light: u8| {
        image::RgbImage::from_fn(64, 48, |x, _| image::Rgb([light, x as u8, 9]))
            .save(frame(i))
            .unwrap();
    };
    (1..=3).for_each(|i| write(i, 40 * i as u8));
    let mut window = Window::open(&[frame(2)], None);
    window.denoised();
    window.press(Key::ArrowRight);
    window.wait_for("next", |viewer| viewer.session.opened().unwrap().path.ends_with("f.0003.png"));
    window.denoised();
    window.press(Key::W);
    assert!(window.0.state().session.watch.is_some());
    write(3, 250);
    let red = |viewer: &Viewer| viewer.session.image(Shown::Noisy).unwrap().pixels()[0][0];
    window.wait_for("changed", |viewer| red(viewer) > 0.9);
    window.denoised();
    window.picture("watched");
}

#[test]
fn another_layer_can_be_the_color() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("layers.exr");
    write_layers(&file, &[("Fog.Combined", 0.25), ("Composite.Combined", 0.75)]);
    let mut window = Window::open(std::slice::from_ref(&file), None);
    window.denoised();
    let light = |viewer: &Viewer| viewer.session.image(Shown::Noisy).unwrap().pixels()[0][0];
    assert_eq!(window.0.state().session.colors, ["Fog.Combined", "Composite.Combined"]);
    assert_eq!(light(window.0.state()), 0.25);
    window.picture("layers");
    let color = Some("Composite.Combined".into());
    window.0.state_mut().session.choose(Wish { color, ..Wish::default() });
    window.wait_for("chosen", |viewer| light(viewer) == 0.75);
    assert_eq!(window.0.state().session.colors.len(), 2, "the choice stays");
}

#[test]
fn another_view_can_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("stereo.exr");
    write_views(&file, &[("left", 0.25), ("right", 0.75)]);
    let mut window = Window::open(std::slice::from_ref(&file), None);
    window.denoised();
    let light = |viewer: &Viewer| {
        let image = |shown| viewer.session.image(shown).map(|image| image.pixels()[0][0]);
        [image(Shown::Noisy), image(Shown::Denoised)]
    };
    assert_eq!(window.0.state().session.opened().unwrap().views(), ["left", "right"]);
    assert_eq!(light(window.0.state()), [Some(0.25); 2]);
    window.0.state_mut().session.choose(Wish { view: 1, ..Wish::default() });
    window.wait_for("right", |viewer| light(viewer) == [Some(0.75); 2]);
    let outcome = window.0.state().session.denoised.as_ref().unwrap();
    assert_eq!(outcome.results.len(), 2, "both are denoised");
}

/// Writes an EXR file with one constant part per view.
fn write_views(path: &Path, views: &[(&str, f32)]) {
    let part = |(name, value): &(&str, f32)| {
        let samples = FlatSamples::F32(vec![*value; 64 * 64]);
        let channels = ["R", "G", "B"].map(|c| AnyChannel::new(c, samples.clone()));
        let attributes =
            LayerAttributes { view_name: Some((*name).into()), ..LayerAttributes::named(*name) };
        let channels = AnyChannels::sort(channels.into_iter().collect());
        Layer::new((64, 64), attributes, Encoding::FAST_LOSSLESS, channels)
    };
    let bounds = ImageAttributes::with_size((64, 64));
    let parts: Vec<_> = views.iter().map(part).collect();
    exr::prelude::Image::from_layers(bounds, parts).write().to_file(path).unwrap();
}

/// Writes an EXR file with constant layers.
fn write_layers(path: &Path, layers: &[(&str, f32)]) {
    let channel = |(name, value): &(&str, f32)| {
        let samples = FlatSamples::F32(vec![*value; 64 * 64]);
        ["R", "G", "B"].map(|c| AnyChannel::new(format!("{name}.{c}").as_str(), samples.clone()))
    };
    let channels = AnyChannels::sort(layers.iter().flat_map(channel).collect());
    let image = exr::prelude::Image::from_channels((64, 64), channels);
    image.write().to_file(path).unwrap();
}
