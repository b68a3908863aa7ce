//! The lines at the bottom: a message, progress, and the pixel under the cursor.

use eframe::egui::{ProgressBar, RichText, Ui};

use crate::session::Session;
use crate::state::keys::Action;
use crate::state::looking::Shown;
use crate::state::pixel;
use crate::ui::theme::{ACCENT, ALARM, QUIET};

/// Shows the lines; returns what the user asks for.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut asked = None;
    if let Some(message) = session.message.clone() {
        ui.horizontal_wrapped(|ui| {
            let text = RichText::new(&message.text);
            ui.label(if message.is_error { text.color(ALARM) } else { text });
            if ui.small_button("Dismiss").clicked() {
                session.message = None;
            }
        });
    }
    ui.horizontal(|ui| {
        // What Escape cancels first comes first.
        if let Some(name) = session.opening.name() {
            ui.spinner();
            ui.label(format!("Opening {name}…"));
        } else if let Some(done) = session.progress {
            let bar = ProgressBar::new(done).desired_width(140.0).fill(ACCENT.gamma_multiply(0.6));
            ui.add(bar.show_percentage());
        }
        let is_busy = session.is_opening() || session.is_denoising();
        if is_busy && ui.small_button("Cancel").on_hover_text("Esc").clicked() {
            asked = Some(Action::Cancel);
        }
        let hint = if session.loaded.is_some() { "point at a pixel to read its light" } else { "" };
        let text = reading(session).unwrap_or_else(|| hint.into());
        ui.label(RichText::new(text).monospace().color(QUIET));
    });
    asked
}

/// The values of the pixel under the cursor, in linear light.
fn reading(session: &Session) -> Option<String> {
    let (at, view) = (session.pointed?, session.opened()?.view());
    let images = [
        ("noisy", session.image(Shown::Noisy)),
        ("denoised", session.image(Shown::Denoised)),
        ("reference", session.image(Shown::Reference).filter(|_| session.available().reference)),
        ("albedo", view.albedo()),
        ("normal", view.normal()),
    ];
    let index = at[1] as usize * view.color().width() as usize + at[0] as usize;
    let alpha = view.alpha().and_then(|alpha| alpha.get(index).copied());
    let perceived = session.perceived().and_then(|found| found.errors.get(index));
    Some(pixel::reading(at, perceived.copied(), &images, alpha))
}
