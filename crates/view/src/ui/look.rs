//! Display settings: exposure, tone curve, comparison. None of them changes a result.

use eframe::egui::{ComboBox, Grid, Slider, Ui};

use crate::session::Session;
use crate::state::looking::{Layout, Looking, Measure, Shown};
use crate::state::tone::{Curve, Tone};
use crate::ui::theme::NAMES;

/// Shows the settings that apply to the shown images.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) {
    let visible = session.looking.visible(session.available());
    let has_reference = session.subtracted() == Shown::Reference;
    let Session { looking, tone, .. } = session;
    ui.spacing_mut().slider_width = 96.0;
    Grid::new("look").num_columns(2).min_col_width(NAMES).spacing([12.0, 6.0]).show(ui, |ui| {
        exposure(ui, tone);
        if looking.layout != Layout::Single {
            ui.label("Left image");
            left(ui, looking);
            ui.end_row();
        }
        if visible.contains(&Shown::Difference) {
            difference(ui, looking, has_reference);
        }
    });
}

fn exposure(ui: &mut Ui, tone: &mut Tone) {
    ui.label("Exposure")
        .on_hover_text("E brighter, Shift E darker, 0 reset; the saved result does not change");
    let stops = Tone::STOPS;
    ui.add(Slider::new(&mut tone.exposure, -stops..=stops).text("EV").fixed_decimals(1));
    ui.end_row();
    ui.label("Tone curve").on_hover_text("T; the saved result does not change");
    ui.horizontal(|ui| {
        for (curve, name) in Curve::ALL {
            ui.selectable_value(&mut tone.curve, curve, name);
        }
    });
    ui.end_row();
}

/// What a difference shows, and its amplification.
fn difference(ui: &mut Ui, looking: &mut Looking, has_reference: bool) {
    ui.label("Difference").on_hover_text("P");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut looking.measure, Measure::Light, "Light");
        let hint = "how much an eye notices when the image and the reference are shown in turn";
        ui.add_enabled_ui(has_reference, |ui| {
            ui.selectable_value(&mut looking.measure, Measure::Perceived, "FLIP")
                .on_hover_text(hint)
                .on_disabled_hover_text(
                    "needs a reference of the same size (R); further layers have none",
                )
        });
    });
    ui.end_row();
    if looking.measure == Measure::Light || !has_reference {
        ui.label("Amplify");
        let [least, most] = Looking::AMPLIFICATION;
        let slider = Slider::new(&mut looking.amplification, least..=most).logarithmic(true);
        ui.add(slider.text("×").max_decimals(0));
        ui.end_row();
    }
}

fn left(ui: &mut Ui, looking: &mut Looking) {
    let name = looking.left.name();
    ComboBox::from_id_salt("left").selected_text(name).width(110.0).show_ui(ui, |ui| {
        for shown in Shown::ALL {
            ui.selectable_value(&mut looking.left, shown, shown.name());
        }
    });
}
