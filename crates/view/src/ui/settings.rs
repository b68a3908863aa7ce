//! The denoising settings: weights, precision, and further inputs.

use eframe::egui::{Grid, RichText, Ui};
use wgdenoise::{Precision, Quality};
use wgdenoise_files::escaped;

use crate::session::Session;
use crate::state::keys::Action;
use crate::state::settings::{ALPHAS, Settings, Source};
use crate::ui::theme::{NAMES, QUIET};

/// Shows the settings; returns the user's action. A change denoises again.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let before = session.settings.clone();
    let mut asked = None;
    Grid::new("settings").num_columns(2).min_col_width(NAMES).spacing([12.0, 6.0]).show(ui, |ui| {
        asked = weights(ui, &session.settings);
        quality(ui, &mut session.settings);
        precision(ui, &mut session.settings);
        inputs(ui, session);
        alpha(ui, session);
        ui.label("Skip").on_hover_text("areas of one value are copied, not denoised");
        ui.checkbox(&mut session.settings.skip_clean, "constant areas");
        ui.end_row();
    });
    if session.settings != before {
        session.denoise();
    }
    asked
}

/// The source of the weights.
fn weights(ui: &mut Ui, settings: &Settings) -> Option<Action> {
    let mut asked = None;
    ui.label("Weights").on_hover_text("or drop a weights file, or a folder of weights");
    ui.horizontal(|ui| {
        let choices = [
            (matches!(settings.weights, Source::BuiltIn), "Built in", Action::BuiltInWeights),
            (matches!(settings.weights, Source::File(_)), "File…", Action::OpenWeights),
            (matches!(settings.weights, Source::Folder(_)), "Folder…", Action::OpenWeightsFolder),
        ];
        for (is_chosen, name, action) in choices {
            if ui.selectable_label(is_chosen, name).clicked() {
                asked = Some(action);
            }
        }
    });
    ui.end_row();
    if let Some(path) = settings.weights.path() {
        ui.label("");
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let text = RichText::new(escaped(&name)).small().color(QUIET);
        ui.label(text).on_hover_text(escaped(&path.to_string_lossy()));
        ui.end_row();
    }
    asked
}

/// The tier, or the network size for a folder. A weights file offers no choice.
fn quality(ui: &mut Ui, chosen: &mut Settings) {
    ui.label("Quality");
    let has_tiers = !matches!(chosen.weights, Source::File(_));
    ui.add_enabled_ui(has_tiers, |ui| {
        ui.horizontal(|ui| {
            for (value, name) in
                [(Quality::Fast, "Fast"), (Quality::Balanced, "Balanced"), (Quality::High, "High")]
            {
                ui.selectable_value(&mut chosen.quality, value, name)
                    .on_hover_text("each tier takes about twice as long as the one before");
            }
        });
    });
    ui.end_row();
}

fn precision(ui: &mut Ui, chosen: &mut Settings) {
    ui.label("Precision").on_hover_text("of the network; 32 bit takes twice the memory");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut chosen.precision, Precision::F16, "16 bit");
        ui.selectable_value(&mut chosen.precision, Precision::F32, "32 bit");
    });
    ui.end_row();
}

/// Albedo and normals.
fn inputs(ui: &mut Ui, session: &mut Session) {
    let view = session.opened().map(|opened| opened.view());
    let [albedo, normal] =
        view.map_or([false; 2], |view| [view.albedo().is_some(), view.normal().is_some()]);
    let chosen = &mut session.settings;
    ui.label("Use");
    ui.horizontal(|ui| {
        ui.add_enabled_ui(albedo, |ui| ui.checkbox(&mut chosen.albedo, "albedo"));
        ui.add_enabled_ui(normal, |ui| ui.checkbox(&mut chosen.normal, "normal"));
    });
    ui.end_row();
    if matches!(chosen.weights, Source::Folder(_)) {
        ui.label("");
        let hint = "denoise albedo and normal first, with the folder's weights for them";
        ui.checkbox(&mut chosen.prefilter, "prefilter").on_hover_text(hint);
        ui.end_row();
    }
}

fn alpha(ui: &mut Ui, session: &mut Session) {
    if session.opened().is_none_or(|opened| opened.view().alpha().is_none()) {
        return;
    }
    ui.label("Alpha").on_hover_text("Auto denoises it if any pixel is partly transparent");
    ui.horizontal(|ui| {
        for (value, name) in ALPHAS {
            ui.selectable_value(&mut session.settings.alpha, value, name);
        }
    });
    ui.end_row();
}
