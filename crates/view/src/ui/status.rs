//! The status lines: running work, messages, and the pixel under the cursor. Their height is fixed,
//! so that the image does not move.

use eframe::egui::{FontId, ProgressBar, RichText, Sense, TextStyle, Ui, UiBuilder};

use crate::session::Session;
use crate::state::keys::Action;
use crate::state::looking::Shown;
use crate::state::pixel;
use crate::ui::theme::{ACCENT, ALARM, QUIET};

/// Shows the lines; returns the user's action.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        asked = work(ui, session);
        message(ui, session);
    });
    let Some([width, height]) = session.opened().map(|opened| opened.size()) else { return asked };
    let line = |at| reading(session, at).unwrap_or_default();
    let hint = || "Point at a pixel to read its values".into();
    let text = session.pointed.map_or_else(hint, line);
    let height = height_of(ui, line([width - 1, height - 1]));
    let size = [ui.available_width(), height].into();
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.label(RichText::new(text).monospace().color(QUIET));
    });
    asked
}

/// Running work, in the order in which Escape cancels it.
fn work(ui: &mut Ui, session: &Session) -> Option<Action> {
    if let Some(name) = session.opening.name() {
        ui.spinner();
        ui.label(format!("Opening {name}…"));
    } else if let Some(done) = session.progress {
        let bar = ProgressBar::new(done).desired_width(140.0).fill(ACCENT.gamma_multiply(0.6));
        ui.add(bar.show_percentage());
    } else {
        return None;
    }
    let button = ui.small_button("Cancel").on_hover_text("Esc");
    button.clicked().then_some(Action::Cancel)
}

/// A message, or a hint on the keys.
fn message(ui: &mut Ui, session: &mut Session) {
    if let Some(message) = session.message.clone() {
        let text = RichText::new(&message.text);
        ui.label(if message.is_error { text.color(ALARM) } else { text });
        if ui.small_button("Dismiss").on_hover_text("Esc").clicked() {
            session.message = None;
        }
    } else if session.loaded.is_some() {
        ui.label(RichText::new("Space: toggle noisy and denoised").color(QUIET));
        ui.add_space(10.0);
        ui.label(RichText::new("?: all keys").color(QUIET));
    } else {
        ui.label("");
    }
}

/// The height of a reading at this width.
fn height_of(ui: &Ui, text: String) -> f32 {
    let font: FontId = TextStyle::Monospace.resolve(ui.style());
    ui.painter().layout(text, font, QUIET, ui.available_width()).size().y
}

/// The values of a pixel, in linear light.
fn reading(session: &Session, at: [u32; 2]) -> Option<String> {
    let view = session.opened()?.view();
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
