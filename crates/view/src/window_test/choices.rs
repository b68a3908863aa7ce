//! Choosing layers, weights and measures updates the result.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use eframe::egui::accesskit::Role;

use crate::state::keys::Action;
use crate::state::looking::Measure;
use crate::state::tone::srgb;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/oidn").join(name)
}

/// Writes a small file with albedo, normals and two light groups.
fn small(folder: &Path) -> PathBuf {
    let path = folder.join("small.exr");
    let names = ["Combined", "Combined_key", "Combined_fill", "Denoising Albedo"];
    let names = names.map(|name| format!("View.{name}"));
    let mut layers: Vec<_> = names.iter().map(String::as_str).zip([0.5, 0.2, 0.3, 0.4]).collect();
    layers.push(("View.Denoising Normal", 0.577));
    write_layers(&path, &layers);
    path
}

impl Window {
    fn session(&self) -> &crate::session::Session {
        &self.0.state().session
    }

    fn click(&mut self, label: &str) {
        self.0.get_by_label(label).click();
        self.0.run_steps(2);
    }

    fn copied_command(&mut self) -> String {
        commands::act(&mut self.0.state_mut().session, Action::CopyCommand).unwrap()
    }

    fn light(&self) -> Vec<[f32; 3]> {
        self.session().image(Shown::Denoised).unwrap().pixels().to_vec()
    }
}

#[test]
fn ticked_layers_are_denoised_along() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[small(folder.path())], None);
    window.denoised();
    let layers = |window: &Window| {
        let outcome = window.session().denoised.as_ref().unwrap();
        let names = window.session().opened().unwrap().view().layers().iter();
        let lights = outcome.results[0].layers.iter().map(|image| image.pixels()[0][0]);
        names.map(|layer| layer.name.clone()).zip(lights).collect::<Vec<_>>()
    };
    assert_eq!(layers(&window), []);
    window.click("View.Combined_fill");
    window.wait_for("read", |v| !v.session.is_opening() && v.session.wish.layers.is_some());
    window.denoised();
    assert_eq!(layers(&window), [("View.Combined_fill".into(), 0.3)]);
    assert!(window.copied_command().ends_with(" --layers=View.Combined_fill"));
    window.picture("further_layers");
    window.click("find by name");
    window.wait_for("read", |viewer| viewer.session.opened().unwrap().view().layers().len() == 2);
    window.denoised();
    assert_eq!(layers(&window).len(), 2);
    assert!(window.copied_command().ends_with(" --layers=auto"));
}

#[test]
fn patterns_choose_layers_and_one_that_matches_nothing_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[small(folder.path())], None);
    window.denoised();
    let mut type_in = |text: &str| {
        window.0.get_by_role(Role::TextInput).click();
        window.0.run_steps(2);
        window.press_with(Modifiers::COMMAND, Key::A);
        window.0.event(Event::Text(text.into()));
        window.press(Key::Enter);
        window.wait_for("read", |viewer| !viewer.session.is_opening());
        window.picture("patterns");
        window.session().opened().unwrap().view().layers().len()
    };
    assert_eq!(type_in("*_key, *_f?ll"), 2);
    assert_eq!(type_in("nothing*"), 2);
    assert!(window.message().contains("has no further layer `nothing*`"));
    assert!(window.copied_command().ends_with(" --layers='*_key,*_f?ll'"));
    assert_eq!(window.session().wish.layers, window.session().opened().unwrap().wish.layers);
}

#[test]
fn a_further_layer_is_shown_in_place_of_the_color() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    let mut window = Window::open(std::slice::from_ref(&file), Some(&file));
    window.denoised();
    window.click("find by name");
    window.wait_for("read", |viewer| viewer.session.opened().unwrap().view().layers().len() == 2);
    window.denoised();
    let color = window.picture("color");
    assert_eq!(window.session().subtracted(), Shown::Reference);
    window.click("Shown");
    window.0.get_all_by_label("View.Combined_key").last().unwrap().click();
    window.0.run_steps(2);
    window.wait_for("shown", |viewer| viewer.session.layer().is_some());
    assert!(difference(&window.picture("further_layer"), &color) > 10.0);
    let lights = [Shown::Noisy, Shown::Denoised].map(|shown| {
        let image = window.session().image(shown).unwrap();
        image.pixels()[0][0]
    });
    assert_eq!(lights, [0.2; 2]);
    assert_eq!(window.session().subtracted(), Shown::Noisy, "the reference is that of the color");
    let saved = folder.path().join("layer.png");
    commands::save_comparison(&mut window.0.state_mut().session, &saved);
    window.message();
    let screen = (srgb(0.2) * 255.0).round() as u8;
    assert_eq!(image::open(&saved).unwrap().to_rgb8().get_pixel(9, 9).0, [screen; 3]);
    window.click("Fast");
    window.denoised();
    window.wait_for("shown", |viewer| viewer.session.available().denoised);
    window.0.state_mut().session.further.chosen = None;
    window.0.run_steps(3);
    assert_eq!(difference(&window.picture("color_again"), &color), 0.0);
}

#[test]
fn a_dropped_weights_file_is_used_and_a_broken_one_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[noisy()], None);
    window.denoised();
    let balanced = window.light();
    window.drop_files(&[fixture("rt_hdr_alb_nrm.tza")], Modifiers::NONE);
    assert!(window.session().is_denoising());
    window.denoised();
    let others = window.light();
    assert_ne!(others, balanced);
    assert!(window.copied_command().contains("rt_hdr_alb_nrm.tza"));
    window.0.get_by_label("rt_hdr_alb_nrm.tza");
    window.picture("weights_file");
    let broken = folder.path().join("broken.safetensors");
    fs::write(&broken, "no weights").unwrap();
    window.drop_files(std::slice::from_ref(&broken), Modifiers::NONE);
    let error = window.message();
    assert!(error.contains("broken.safetensors: is not a weights file"), "{error}");
    assert_eq!(window.light(), others, "the last result stays");
    window.click("Built in");
    window.denoised();
    assert_eq!(window.light(), balanced);
}

#[test]
fn a_folder_of_weights_can_denoise_albedo_and_normal_first() {
    let folder = tempfile::tempdir().unwrap();
    let put = |from: &str, to: &str| fs::copy(fixture(from), folder.path().join(to)).unwrap();
    put("rt_hdr_alb_nrm.tza", "rt_hdr_alb_nrm.tza");
    let mut window = Window::open(&[noisy()], None);
    window.denoised();
    window.drop_files(&[folder.path().into()], Modifiers::NONE);
    window.denoised();
    let noisy_inputs = window.light();
    window.click("prefilter");
    let error = window.message();
    assert!(error.contains("has no rt_hdr_calb_cnrm.tza"), "{error}");
    put("rt_hdr_alb_nrm.tza", "rt_hdr_calb_cnrm.tza");
    put("rt_alb.tza", "rt_alb.tza");
    put("rt_alb.tza", "rt_nrm.tza");
    window.click("Denoise now");
    window.denoised();
    assert_ne!(window.light(), noisy_inputs, "the same weights get other images");
    assert!(window.copied_command().ends_with(" --prefilter"));
    window.picture("prefilter");
}

#[test]
fn the_error_that_can_be_seen_is_a_map_and_a_figure() {
    let mut window = Window::open(&[noisy()], Some(&sample("still_life_reference.exr")));
    window.denoised();
    window.press(Key::Num6);
    let of_light = window.picture("difference_of_light");
    window.press(Key::P);
    assert_eq!(window.session().looking.measure, Measure::Perceived);
    window.wait_for("perceived", |viewer| viewer.session.perceiving.found().is_some());
    let map = window.picture("perceived");
    assert!(difference(&map, &of_light) > 4.0);
    let means = window.session().perceiving.found().unwrap().means;
    assert!(means[0] > means[1] && means[1] > 0.0, "{means:?}");
    assert_eq!(window.0.get_all_by_label("FLIP").count(), 2, "the choice and the figure");
    window.press_with(Modifiers::SHIFT, Key::E);
    let is_darker = |viewer: &Viewer| viewer.session.perceiving.found().unwrap().means != means;
    window.wait_for("computed at the other exposure", is_darker);
    window.press(Key::P);
    assert_eq!(window.session().looking.measure, Measure::Light);
    window.drop_files(&[sample("still_life_8spp.exr")], Modifiers::SHIFT);
    window.wait_for("another reference", |viewer| {
        viewer.session.perceiving.found().is_some_and(|found| found.means[0] == 0.0)
    });
}

#[test]
fn without_a_reference_a_perceived_error_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[small(folder.path())], None);
    window.denoised();
    window.press(Key::P);
    assert!(window.message().contains("there is no reference"));
    window.picture("no_reference");
}
