//! A text field for a path, where the system has no file dialog.

use std::path::PathBuf;

use eframe::egui::{Align2, Context, Key, TextEdit, Window};

use crate::session::Session;
use crate::work::{Prompt, Purpose};

/// Shows the field while a path is wanted; returns the typed path and its purpose.
pub(crate) fn show(context: &Context, session: &mut Session) -> Option<(Purpose, PathBuf)> {
    let Prompt { purpose, path } = session.prompt.as_mut()?;
    let (mut is_open, mut is_done) = (true, false);
    Window::new(title(*purpose))
        .open(&mut is_open)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .collapsible(false)
        .resizable(false)
        .default_width(540.0)
        .show(context, |ui| {
            ui.label("This system has no file dialog. Type the path:");
            let line = ui.add(TextEdit::singleline(path).desired_width(520.0).hint_text("path"));
            if line.lost_focus() {
                is_done = ui.input(|input| input.key_pressed(Key::Enter));
            } else {
                line.request_focus();
            }
            let saves = matches!(purpose, Purpose::Save | Purpose::SaveComparison);
            is_done |= ui.button(if saves { "Save" } else { "Open" }).clicked();
        });
    is_open &= !context.input(|input| input.key_pressed(Key::Escape));
    let typed = (*purpose, PathBuf::from(path.trim()));
    if !is_open || is_done {
        session.prompt = None;
    }
    (is_done && is_open).then_some(typed)
}

fn title(purpose: Purpose) -> &'static str {
    match purpose {
        Purpose::Open => "Open noisy images",
        Purpose::Reference => "Open a reference",
        Purpose::Weights => "Open a weights file",
        Purpose::WeightsFolder => "Open a folder of weights",
        Purpose::Save => "Save the result",
        Purpose::SaveComparison => "Save the comparison",
    }
}
