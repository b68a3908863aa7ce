//! The window before anything is open.

use std::path::PathBuf;

use eframe::egui::{RichText, Ui};

use crate::session::Session;
use crate::state::keys::Action;
use crate::ui::recent;
use crate::ui::theme::QUIET;

/// How the user chose to begin.
pub(crate) enum Beginning {
    Do(Action),
    Open(PathBuf),
}

/// Draws the empty window: how to open an image, and a button for the sample if it is found.
pub(crate) fn show(ui: &mut Ui, session: &Session) -> Option<Beginning> {
    let mut chosen = None;
    ui.vertical_centered(|ui| {
        let recent = &session.recent.entries;
        let above = 110.0 + 12.0 * recent.len() as f32;
        ui.add_space((ui.available_height() / 2.0 - above).max(20.0));
        if let Some(name) = session.opening.name() {
            ui.spinner();
            ui.label(format!("Opening {name}…"));
            return;
        }
        ui.label(RichText::new("Drop a noisy render here").size(26.0));
        ui.label(
            RichText::new("EXR, PNG or JPEG; albedo and normals are found by their names")
                .color(QUIET),
        );
        ui.add_space(14.0);
        if ui.button("Open…").clicked() {
            chosen = Some(Beginning::Do(Action::Open));
        }
        if let Some(sample) = sample()
            && ui.button("Try the sample").on_hover_text(sample.display().to_string()).clicked()
        {
            chosen = Some(Beginning::Open(sample));
        }
        if !recent.is_empty() {
            ui.add_space(14.0);
            ui.label(RichText::new("Recent").color(QUIET));
        }
        if let Some(path) = recent::list(ui, recent) {
            chosen = Some(Beginning::Open(path));
        }
        ui.add_space(14.0);
        ui.label(RichText::new("? lists the keys").color(QUIET));
    });
    chosen
}

/// Finds the repository's sample, below the current folder or above the program.
pub(crate) fn sample() -> Option<PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    let above = program.ancestors().skip(1).map(PathBuf::from);
    let files = [PathBuf::new()].into_iter().chain(above);
    files.map(|folder| folder.join("samples/still_life_8spp.exr")).find(|file| file.is_file())
}
