//! The toolbar: files, images, layout, zoom.

use eframe::egui::{Button, Ui};

use crate::session::Session;
use crate::state::keys::Action;
use crate::state::looking::{Layout, Looking, Shown};
use crate::ui::recent;

/// Shows the toolbar; returns the user's action.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        if ui.button("Open").on_hover_text("Ctrl O").clicked() {
            asked = Some(Action::Open);
        }
        recent::menu(ui, session);
        let mut button = |ui: &mut Ui, text: &str, hint: &str, action| {
            if ui.button(text).on_hover_text(hint).clicked() {
                asked = Some(action);
            }
        };
        if session.loaded.is_some() {
            button(ui, "Save", "Ctrl S", Action::Save);
            ui.separator();
            images(ui, session, &mut button);
            ui.separator();
            layouts(ui, &mut session.looking);
            ui.separator();
            button(ui, "Fit", "F", Action::Fit);
            button(ui, "1:1", "Z", Action::OneToOne);
            ui.label(format!("{:.0} %", session.transform.zoom() * 100.0));
            ui.separator();
        }
        button(ui, "?", "keys", Action::Help);
    });
    asked
}

/// A button for each image, faint if it is missing.
fn images(ui: &mut Ui, session: &Session, button: &mut impl FnMut(&mut Ui, &str, &str, Action)) {
    let available = session.available();
    let visible = session.looking.visible(available)[1];
    for (i, shown) in Shown::ALL.into_iter().enumerate() {
        ui.scope(|ui| {
            if shown == visible {
                ui.visuals_mut().widgets.inactive.weak_bg_fill = ui.visuals().selection.bg_fill;
            }
            ui.add_enabled_ui(available.has(shown), |ui| {
                button(ui, shown.name(), &format!("{}", i + 1), Action::Show(shown));
            });
        });
    }
}

/// How images share the window.
fn layouts(ui: &mut Ui, looking: &mut Looking) {
    for (layout, name) in Layout::ALL {
        let button = Button::selectable(looking.layout == layout, name);
        if ui.add(button).clicked() {
            looking.layout = layout;
        }
    }
}
