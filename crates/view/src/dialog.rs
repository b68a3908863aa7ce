//! The system's file dialogs, which never block the window.

use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use rfd::{AsyncFileDialog, FileHandle};

use crate::work::{Desk, Prompt, Purpose, Report};

const IMAGES: [&str; 4] = ["exr", "png", "jpg", "jpeg"];
const WEIGHTS: [&str; 2] = ["safetensors", "tza"];

/// The files chosen in a dialog, once it is closed; none if the user chose none.
type Chosen = Pin<Box<dyn Future<Output = Vec<FileHandle>> + Send>>;

fn one(file: impl Future<Output = Option<FileHandle>> + Send + 'static) -> Chosen {
    Box::pin(async move { file.await.into_iter().collect() })
}

fn several(files: impl Future<Output = Option<Vec<FileHandle>>> + Send + 'static) -> Chosen {
    Box::pin(async move { files.await.unwrap_or_default() })
}

/// Asks which files to open.
pub(crate) fn open(purpose: Purpose, folder: Option<&Path>, desk: Desk) {
    let images = at(folder).add_filter("Images", &IMAGES);
    let chosen: Chosen = match purpose {
        Purpose::Open => several(images.set_title("Open noisy images").pick_files()),
        Purpose::Weights => {
            let weights = at(folder).add_filter("Weights", &WEIGHTS);
            one(weights.set_title("Open a weights file").pick_file())
        }
        Purpose::WeightsFolder => {
            one(at(folder).set_title("Open a folder of Open Image Denoise's weights").pick_folder())
        }
        _ => one(images.set_title("Open a reference").pick_file()),
    };
    wait(desk, Prompt { purpose, path: String::new() }, chosen);
}

/// Asks where to save. The system confirms before it replaces a file.
pub(crate) fn save(purpose: Purpose, suggested: &Path, desk: Desk) {
    let extensions: &[&str] = if purpose == Purpose::Save { &IMAGES } else { &["png"] };
    let name = suggested.file_name().unwrap_or_default().to_string_lossy();
    let dialog = at(suggested.parent()).add_filter("Images", extensions).set_file_name(name);
    let path = suggested.to_string_lossy().into_owned();
    wait(desk, Prompt { purpose, path }, one(dialog.save_file()));
}

fn at(folder: Option<&Path>) -> AsyncFileDialog {
    let folder = folder.and_then(|folder| folder.canonicalize().ok());
    match folder {
        Some(folder) => AsyncFileDialog::new().set_directory(folder),
        None => AsyncFileDialog::new(),
    }
}

/// Reports the chosen files once the dialog is closed, or that the system has no dialog.
fn wait(desk: Desk, prompt: Prompt, chosen: Chosen) {
    thread::spawn(move || {
        HAS_FAILED.store(false, Ordering::Relaxed);
        let files = pollster::block_on(chosen);
        let paths: Vec<_> = files.iter().map(|file| PathBuf::from(file.path())).collect();
        let has_failed = paths.is_empty() && HAS_FAILED.load(Ordering::Relaxed);
        desk.report(if has_failed {
            Report::NoDialog(prompt)
        } else {
            Report::Chosen(prompt.purpose, paths)
        });
    });
}

/// Whether a dialog could not be shown. The dialog library reports that only to the log.
static HAS_FAILED: AtomicBool = AtomicBool::new(false);

/// Watches the log for dialogs that cannot be shown.
struct Listener;

impl log::Log for Listener {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() == log::Level::Error && metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            HAS_FAILED.store(true, Ordering::Relaxed);
        }
    }

    fn flush(&self) {}
}

/// Starts reporting dialogs that cannot be shown. Call it once, before any dialog.
pub(crate) fn listen() {
    if log::set_logger(&Listener).is_ok() {
        log::set_max_level(log::LevelFilter::Error);
    }
}
