//! The system's dialogs for files, which never block the window.

use std::path::{Path, PathBuf};
use std::thread;

use rfd::AsyncFileDialog;

use crate::work::{Desk, Purpose, Report};

const IMAGES: [&str; 4] = ["exr", "png", "jpg", "jpeg"];

/// Asks for images to open.
pub(crate) fn open(purpose: Purpose, folder: Option<&Path>, desk: Desk) {
    let dialog = at(folder).add_filter("Images", &IMAGES);
    if purpose == Purpose::Reference {
        let chosen = dialog.set_title("Open a reference").pick_file();
        wait(desk, purpose, async move { chosen.await.into_iter().collect() });
    } else {
        let chosen = dialog.set_title("Open noisy images").pick_files();
        wait(desk, purpose, async move { chosen.await.into_iter().flatten().collect() });
    }
}

/// Asks where to save. The system asks before a file is replaced.
pub(crate) fn save(purpose: Purpose, suggested: &Path, desk: Desk) {
    let extensions: &[&str] = if purpose == Purpose::Save { &IMAGES } else { &["png"] };
    let name = suggested.file_name().unwrap_or_default().to_string_lossy();
    let dialog = at(suggested.parent()).add_filter("Images", extensions).set_file_name(name);
    let chosen = dialog.save_file();
    wait(desk, purpose, async move { chosen.await.into_iter().collect() });
}

fn at(folder: Option<&Path>) -> AsyncFileDialog {
    let folder = folder.and_then(|folder| folder.canonicalize().ok());
    match folder {
        Some(folder) => AsyncFileDialog::new().set_directory(folder),
        None => AsyncFileDialog::new(),
    }
}

/// Reports the files once the dialog is closed.
fn wait(
    desk: Desk,
    purpose: Purpose,
    chosen: impl Future<Output = Vec<rfd::FileHandle>> + Send + 'static,
) {
    thread::spawn(move || {
        let files = pollster::block_on(chosen);
        let paths = files.iter().map(|file| PathBuf::from(file.path())).collect();
        desk.report(Report::Chosen(purpose, paths));
    });
}
