//! Drops, pinches, typed paths, and the list of recent files.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::DroppedFile;

use super::*;
use crate::state::entry::Entry;
use crate::state::keys::Action;
use crate::work::{Prompt, Purpose, Report};

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        fs::read(&self.0).map_err(|error| error.to_string())
    }
}

impl Window {
    pub(super) fn drop_files(&mut self, paths: &[PathBuf], held: Modifiers) {
        self.0.event(Event::ModifiersChanged(held));
        let input = self.0.input_mut();
        input.dropped_files =
            paths.iter().map(|path| Arc::new(Dropped(path.clone())) as _).collect();
        self.0.step();
        self.0.event(Event::ModifiersChanged(Modifiers::NONE));
        self.0.input_mut().dropped_files.clear();
        self.0.step();
    }
}

fn gray(path: PathBuf, size: [u32; 2]) -> PathBuf {
    image::RgbImage::from_pixel(size[0], size[1], image::Rgb([90; 3])).save(&path).unwrap();
    path
}

#[test]
fn dropped_files_are_opened_together_and_shift_makes_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a.png", "b.png", "r.png"].map(|name| gray(folder.path().join(name), [64, 48]));
    let mut window = Window::open(&[], None);
    window.0.run_steps(2);
    window.drop_files(&files[..2], Modifiers::NONE);
    window.denoised();
    assert_eq!(window.0.state().session.sequence.as_ref().unwrap().len(), 2);
    window.drop_files(&files[2..], Modifiers::SHIFT);
    window.wait_for("reference", |viewer| viewer.session.available().reference);
    assert!(window.0.state().session.opened().unwrap().path.ends_with("a.png"));
}

#[test]
fn a_pinch_zooms_to_the_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&[gray(folder.path().join("a.png"), [640, 480])], None);
    window.denoised();
    let before = window.0.state().session.transform.zoom();
    window.0.hover_at(pos2(500.0, 400.0));
    window.0.step();
    let pointed = window.0.state().session.pointed;
    window.0.event(Event::Zoom(2.0));
    window.0.run_steps(3);
    let session = &window.0.state().session;
    assert_eq!(session.transform.zoom(), 2.0 * before);
    assert!(pointed.is_some() && session.pointed == pointed);
}

#[test]
fn where_there_is_no_dialog_a_path_is_typed_and_no_file_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let input = gray(folder.path().join("a.png"), [64, 48]);
    let mut window = Window::open(std::slice::from_ref(&input), None);
    window.denoised();
    let output = folder.path().join("b.png");
    for expected in ["saved ", "already exists"] {
        let path = output.to_string_lossy().into_owned();
        let prompt = Prompt { purpose: Purpose::Save, path };
        window.0.state().session.desk.report(Report::NoDialog(prompt));
        window.0.run_steps(3);
        window.0.get_by_label("Save the result");
        window.picture("prompt");
        window.press(Key::D);
        window.press(Key::Enter);
        let told = window.message();
        let session = &mut window.0.state_mut().session;
        session.message = None;
        assert!(told.contains(expected) && session.prompt.is_none(), "{told}");
        assert_eq!(session.looking.layout, Layout::Single, "keys are for the text");
    }
    assert!(output.is_file());
    let prompt = Prompt { purpose: Purpose::Open, path: String::new() };
    window.0.state().session.desk.report(Report::NoDialog(prompt));
    window.0.run_steps(3);
    window.press(Key::Escape);
    assert_eq!(window.0.state().session.prompt, None);
}

#[test]
fn a_comparison_never_replaces_a_file_that_was_not_named() {
    let folder = tempfile::tempdir().unwrap();
    let input = gray(folder.path().join("a.png"), [64, 48]);
    let other = gray(folder.path().join("out.png"), [3, 2]);
    let mut window = Window::open(&[input], None);
    window.denoised();
    let session = &mut window.0.state_mut().session;
    commands::typed(session, Purpose::SaveComparison, folder.path().join("out.exr"));
    let told = window.message();
    assert!(told.ends_with("out.exr: comparisons are PNG files; give a name that ends in .png"));
    assert_eq!(image::image_dimensions(&other).unwrap(), (3, 2));
}

#[test]
fn a_result_is_not_saved_into_another_version_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let input = gray(folder.path().join("a.png"), [64, 48]);
    let mut window = Window::open(std::slice::from_ref(&input), None);
    window.denoised();
    gray(input, [640, 480]);
    let session = &mut window.0.state_mut().session;
    commands::save_result(session, &folder.path().join("out.png"));
    let told = window.message();
    assert_eq!(told, "a.png: has changed since it was opened; open it again");
    commands::act(&mut window.0.state_mut().session, Action::Watch);
    let size = |viewer: &Viewer| viewer.session.opened().unwrap().size();
    window.wait_for("the version that was written before", |viewer| size(viewer) == [640, 480]);
}

#[test]
fn a_reference_of_another_size_is_named_and_the_score_stays() {
    let folder = tempfile::tempdir().unwrap();
    let other = gray(folder.path().join("small.png"), [64, 48]);
    let mut window = Window::open(&[noisy()], Some(&other));
    window.denoised();
    window.wait_for("scored", |viewer| viewer.session.figures.is_some_and(|f| f.rows().len() == 1));
    let why = "small.png has 64×48 pixels, not 576×432; open another reference";
    assert_eq!(window.0.get_all_by_label(why).count(), 2, "in the message and over the figures");
    window.0.get_by_label("Compare with a reference…");
}

#[test]
fn cancelling_keeps_the_figures_of_the_noisy_image() {
    let mut window = Window::open(&[noisy()], Some(&sample("still_life_reference.exr")));
    window.wait_for("started", |viewer| viewer.session.is_denoising());
    window.wait_for("reference", |viewer| viewer.session.reference.is_some());
    window.press(Key::Escape);
    window
        .wait_for("compared", |viewer| viewer.session.figures.is_some_and(|f| f.rows().len() == 4));
}

#[test]
fn the_last_files_are_listed_and_missing_ones_cannot_be_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = gray(folder.path().join("here.png"), [64, 48]);
    let mut window = Window::open(&[], None);
    let entry = |path: PathBuf| Entry { exists: path.is_file(), path };
    let entries = vec![entry(path.clone()), entry(folder.path().join("gone.png"))];
    window.0.state().session.desk.report(Report::Recent(entries));
    window.0.run_steps(3);
    window.picture("recent");
    window.0.get_by_label("gone.png").click();
    window.0.run_steps(3);
    assert!(!window.0.state().session.is_opening());
    window.0.get_by_label("here.png").click();
    window.0.run_steps(2);
    window.denoised();
    window.0.get_by_label("Recent");
    assert_eq!(window.0.state().session.opened().unwrap().path, path);
}

#[test]
fn a_pattern_opens_its_frames_and_a_wrong_one_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["f.0001.png", "f.0002.png", "other.png"] {
        gray(folder.path().join(name), [64, 48]);
    }
    let mut window = Window::open(&[folder.path().join("f.####.png")], None);
    window.denoised();
    assert_eq!(window.0.state().session.sequence.as_ref().unwrap().len(), 2);
    window.0.state_mut().session.open(&[folder.path().join("g.####.png")]);
    let message = window.0.state().session.message.clone().unwrap();
    assert!(message.is_error && message.text.ends_with("g.####.png: matches no file"));
}

#[test]
fn at_one_to_one_each_pixel_of_the_screen_is_one_of_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    // For one of the two sizes, the center lies between screen pixels.
    for side in [340, 341] {
        let stripes = image::RgbImage::from_fn(side, side, |x, y| {
            image::Rgb([if (x + y) % 2 == 0 { 255 } else { 60 }; 3])
        });
        stripes.save(&path).unwrap();
        let mut window = Window::open(std::slice::from_ref(&path), None);
        window.denoised();
        window.press(Key::Num1);
        window.press(Key::Z);
        let picture = window.picture("one_to_one");
        let area = window.0.state().session.area;
        let values = |y: u32| {
            let row = (0..area[0] as u32).map(move |x| (x, y));
            let found = row.map(|(x, y)| picture.get_pixel(x, y)[0]);
            found.filter(|v| [255, 60].contains(v)).collect::<Vec<_>>()
        };
        let rows: Vec<_> = (100..picture.height() - 80).map(values).collect();
        let whole: Vec<_> = rows.iter().filter(|row| row.len() > 300).collect();
        assert_eq!(whole.len(), side as usize, "rows");
        for row in whole {
            assert_eq!(row.len(), side as usize, "columns");
            assert!(row.windows(2).all(|pair| pair[0] != pair[1]), "a column twice");
        }
    }
}

#[test]
fn the_image_stays_where_it_is_whatever_there_is_to_tell() {
    let mut window = Window::open(&[noisy()], Some(&sample("still_life_reference.exr")));
    window.denoised();
    window.wait_for("reference", |viewer| viewer.session.available().reference);
    window.0.run_steps(2);
    let area = |window: &Window| window.0.state().session.area;
    let before = area(&window);
    for at in [pos2(480.0, 300.0), pos2(500.0, 400.0), pos2(900.0, 500.0)] {
        window.0.hover_at(at);
        window.0.run_steps(2);
        assert!(window.0.state().session.pointed.is_some());
        assert_eq!(area(&window), before, "{at:?}");
    }
    window.picture("pointed");
    window.0.state_mut().session.tell("this has been told");
    window.0.run_steps(2);
    assert_eq!(area(&window), before);
}
