//! The recent files, as buttons.

use std::path::PathBuf;

use eframe::egui::{Button, Ui};
use wgdenoise_files::escaped;

use crate::session::Session;
use crate::state::entry::Entry;

/// A button for each file, faint if it is missing. Returns the one to open.
pub(crate) fn list(ui: &mut Ui, entries: &[Entry]) -> Option<PathBuf> {
    let mut chosen = None;
    for Entry { path, exists } in entries {
        let name = escaped(&path.file_name().unwrap_or_default().to_string_lossy());
        let button = ui.add_enabled(*exists, Button::new(name).frame(false));
        let whole = escaped(&path.to_string_lossy());
        let missing = format!("{whole} is missing");
        if button.on_hover_text(whole).on_disabled_hover_text(missing).clicked() {
            chosen = Some(path.clone());
        }
    }
    chosen
}

/// The list as a menu.
pub(crate) fn menu(ui: &mut Ui, session: &mut Session) {
    if session.recent.entries.is_empty() {
        return;
    }
    ui.menu_button("Recent", |ui| {
        let chosen = list(ui, &session.recent.entries);
        ui.separator();
        if ui.button("Clear the list").clicked() {
            session.recent.clear(&session.desk);
        }
        if let Some(path) = chosen {
            session.open(&[path]);
            ui.close();
        }
    });
}
