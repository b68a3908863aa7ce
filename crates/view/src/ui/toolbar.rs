//! The row at the top: files, images, layout, zoom, exposure.

use eframe::egui::{Button, ComboBox, Slider, Ui};

use crate::session::Session;
use crate::state::keys::Action;
use crate::state::looking::{Layout, Looking, Shown};
use crate::state::tone::{Curve, Tone};

/// Shows the row; returns what the user asks for.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        let mut button = |ui: &mut Ui, text: &str, hint: &str, action| {
            if ui.button(text).on_hover_text(hint).clicked() {
                asked = Some(action);
            }
        };
        button(ui, "Open", "Ctrl O", Action::Open);
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
            tone(ui, &mut session.tone);
            ui.separator();
        }
        button(ui, "?", "the keys", Action::Help);
    });
    asked
}

/// A button for each image; those that are missing are faint.
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

/// How images share the window, and which one is on the left.
fn layouts(ui: &mut Ui, looking: &mut Looking) {
    for (layout, name) in Layout::ALL {
        let button = Button::selectable(looking.layout == layout, name);
        if ui.add(button).clicked() {
            looking.layout = layout;
        }
    }
    if looking.layout != Layout::Single {
        let left = looking.left.name();
        ComboBox::from_id_salt("left").selected_text(left).width(96.0).show_ui(ui, |ui| {
            for shown in Shown::ALL {
                ui.selectable_value(&mut looking.left, shown, shown.name());
            }
        });
    }
    if looking.shown == Shown::Difference {
        let [least, most] = Looking::AMPLIFICATION;
        let slider = Slider::new(&mut looking.amplification, least..=most).logarithmic(true);
        ui.add(slider.suffix("×").max_decimals(0)).on_hover_text("amplifies the difference");
    }
}

fn tone(ui: &mut Ui, tone: &mut Tone) {
    let stops = Tone::STOPS;
    let slider = Slider::new(&mut tone.exposure, -stops..=stops).suffix(" EV").fixed_decimals(1);
    ui.add(slider).on_hover_text("exposure, for looking only: E and Shift E, 0 resets");
    for (curve, name) in Curve::ALL {
        ui.selectable_value(&mut tone.curve, curve, name);
    }
}
