//! The program as users have it: in its own window, drawn by the machine's adapter, under Xvfb.
//! With `WGDENOISE_SCREENSHOTS` set to a folder, saves pictures of the screen there.
#![cfg(target_os = "linux")]

mod display;
mod drag;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use display::Display;
use image::RgbImage;
use tempfile::TempDir;
use wgdenoise_files::Picture;

/// The program's window on its own display. Dropping it ends both.
struct Desktop {
    display: Display,
    program: Child,
    window: u32,
    /// The user's settings, and where results are saved.
    home: TempDir,
}

impl Drop for Desktop {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

impl Desktop {
    /// Starts the program without any file dialog: no session bus, and no other programs.
    fn open(files: &[&str]) -> Self {
        let (display, home) = (Display::start(), tempfile::tempdir().unwrap());
        let program = Command::new(env!("CARGO_BIN_EXE_wgdenoise-view"))
            .args(files.iter().map(|file| samples().join(file)))
            .env("DISPLAY", &display.name)
            .env("XDG_CONFIG_HOME", home.path())
            .env("XDG_RUNTIME_DIR", home.path())
            .env("PATH", home.path())
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("DBUS_SESSION_BUS_ADDRESS")
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let window = display.window("wgdenoise");
        Self { display, program, window, home }
    }

    /// The image area of the screen, also saved under this name.
    fn image(&self, name: &str) -> RgbImage {
        let screen = self.display.picture();
        if let Some(folder) = std::env::var_os("WGDENOISE_SCREENSHOTS") {
            let name = format!("screen_{name}");
            screen.save(Path::new(&folder).join(name).with_extension("png")).unwrap();
        }
        part(&screen)
    }

    /// Waits until the screen meets the condition and the image has been still for a moment.
    /// Returns the image.
    fn wait_for_image(&self, name: &str, is_so: impl Fn(&RgbImage) -> bool) -> RgbImage {
        let mut before = None;
        Display::wait_for(name, || {
            let screen = self.display.picture();
            let image = part(&screen);
            let is_still = before.as_ref() == Some(&image);
            before = Some(image);
            sleep(Duration::from_millis(100));
            (is_still && is_so(&screen)).then_some(())
        });
        self.image(name)
    }
}

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples")
}

/// The middle of the image area, away from labels, dialog edges and the panel.
fn part(screen: &RgbImage) -> RgbImage {
    image::imageops::crop_imm(screen, 20, 100, 1040, 700).to_image()
}

/// Length of the first highlighted toolbar button: that of the shown image.
fn chosen(screen: &RgbImage) -> usize {
    const ROW_ABOVE_TEXT: u32 = 6;
    let stands_out = |x: &u32| screen.get_pixel(*x, ROW_ABOVE_TEXT).0 == [112, 74, 28];
    let from = (0..screen.width()).skip_while(|x| !stands_out(x));
    from.take_while(stands_out).count()
}

/// `Denoised` is a longer word than `Noisy`.
const LONGER_THAN_NOISY: usize = 62;

/// Mean difference of pixels a few rows apart, in 8-bit values; noise raises it.
fn roughness(image: &RgbImage) -> f64 {
    let below = |y: u32| (y + 4).min(image.height() - 1);
    let apart = |x: u32, y: u32| distance(image, image, [x, y], [x, below(y)]);
    mean(image, apart)
}

fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    mean(a, |x, y| distance(a, b, [x, y], [x, y]))
}

fn distance(a: &RgbImage, b: &RgbImage, [x, y]: [u32; 2], [u, v]: [u32; 2]) -> f64 {
    let channels = a.get_pixel(x, y).0.into_iter().zip(b.get_pixel(u, v).0);
    channels.map(|(a, b)| f64::from(a.abs_diff(b))).sum::<f64>() / 3.0
}

fn mean(image: &RgbImage, value: impl Fn(u32, u32) -> f64) -> f64 {
    let (width, height) = image.dimensions();
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(|(x, y)| value(x, y)).sum::<f64>() / f64::from(width * height)
}

#[test]
fn a_render_is_opened_denoised_looked_at_saved_and_copied() {
    let mut desktop = Desktop::open(&["still_life_8spp.exr"]);
    let denoised = desktop.wait_for_image("denoised", |screen| chosen(screen) > LONGER_THAN_NOISY);
    look(&desktop, &denoised);
    save(&desktop);
    copy(&desktop);
    desktop.display.close(desktop.window);
    let end = Display::wait_for("the end", || desktop.program.try_wait().unwrap());
    assert!(end.success(), "{end}");
    let recent = fs::read_to_string(desktop.home.path().join("wgdenoise/recent")).unwrap();
    assert!(recent.trim().ends_with("samples/still_life_8spp.exr"), "{recent}");
}

/// The window has the keyboard focus, so it learns of Shift.
#[test]
fn dropped_files_are_opened_and_with_shift_they_are_references() {
    let desktop = Desktop::open(&[]);
    let noisy = desktop.home.path().join("ein Büro.exr");
    fs::copy(samples().join("still_life_8spp.exr"), &noisy).unwrap();
    assert!(drag::drop_file(&desktop.display, desktop.window, &noisy));
    let is_denoised = |screen: &RgbImage| chosen(screen) > LONGER_THAN_NOISY;
    let denoised = desktop.wait_for_image("dropped", is_denoised);
    let reference = samples().join("still_life_reference.exr");
    desktop.display.holding("Shift", || {
        assert!(drag::drop_file(&desktop.display, desktop.window, &reference));
    });
    desktop.display.press("3");
    // Another image without noise, once the drop hint no longer covers it.
    desktop.wait_for_image("dropped_reference", |screen| {
        let shown = part(screen);
        difference(&shown, &denoised) > 1.0 && roughness(&shown) < 1.3 * roughness(&denoised)
    });
    assert!(desktop.display.title(desktop.window).starts_with("ein"), "the image stays open");
}

/// The space bar and the wheel show another picture, and both can be undone.
fn look(desktop: &Desktop, denoised: &RgbImage) {
    assert!(roughness(denoised) > 1.0, "it is not blank");
    desktop.display.press("Space");
    let is_noisy = |screen: &RgbImage| (1..LONGER_THAN_NOISY).contains(&chosen(screen));
    let noisy = desktop.wait_for_image("noisy", is_noisy);
    assert!(roughness(&noisy) > 1.3 * roughness(denoised));
    desktop.display.press("Space");
    desktop.wait_for_image("back", |screen| part(screen) == *denoised);
    desktop.display.move_to([500, 420]);
    desktop.display.wheel(5);
    let is_other = |screen: &RgbImage| difference(&part(screen), denoised) > 4.0;
    let zoomed = desktop.wait_for_image("zoomed", is_other);
    assert!(roughness(&zoomed) < roughness(denoised), "larger pixels are smoother");
    desktop.display.press("f");
    desktop.wait_for_image("fit", |screen| part(screen) == *denoised);
}

/// Without a file dialog, the window asks for a path; Escape cancels.
fn save(desktop: &Desktop) {
    let before = desktop.image("before_saving");
    let asks = |screen: &RgbImage| difference(&part(screen), &before) > 0.5;
    desktop.display.press("Ctrl+s");
    desktop.wait_for_image("asked", asks);
    desktop.display.press("Escape");
    desktop.wait_for_image("not_asked", |screen| !asks(screen));
    desktop.display.press("Ctrl+s");
    desktop.wait_for_image("asked_again", asks);
    let path = desktop.home.path().join("clean.exr");
    desktop.display.press("Ctrl+a");
    desktop.display.type_text(&path.to_string_lossy());
    desktop.display.press("Return");
    Display::wait_for("the file", || path.is_file().then_some(()));
    let saved = Picture::open(&path, &Default::default()).unwrap();
    assert_eq!(saved.first().color().size(), (576, 432));
    desktop.wait_for_image("saved", |_| true);
}

/// The clipboard gets the command line, and then the picture.
fn copy(desktop: &Desktop) {
    desktop.display.press("Ctrl+e");
    sleep(Duration::from_millis(500));
    let command = String::from_utf8(desktop.display.clipboard("UTF8_STRING")).unwrap();
    assert!(
        command.starts_with("wgdenoise ") && command.ends_with("8spp.denoised.exr"),
        "{command}"
    );
    desktop.display.press("Ctrl+c");
    let png = Display::wait_for("the picture", || {
        let pasted = desktop.display.clipboard("image/png");
        image::load_from_memory(&pasted).ok()
    });
    assert_eq!((png.width(), png.height()), (576, 432));
}
