//! The right-hand panel: the file, the denoising settings, and the result.

use eframe::egui::{Button, Grid, RichText, ScrollArea, Slider, Ui};
use wgdenoise_files::escaped;

use crate::commands;
use crate::compare::{Figures, flip_row};
use crate::open::Wish;
use crate::session::Session;
use crate::state::keys::Action;
use crate::ui::theme::{QUIET, choice};
use crate::ui::{layers, look, settings};

/// Shows the panel; returns the user's action.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut asked = None;
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.add_space(6.0);
        file(ui, session);
        asked = sequence(ui, session).or(asked);
        explanation(ui, session);
        color(ui, session);
        layers::show(ui, session);
        view(ui, session);
        ui.separator();
        look::show(ui, session);
        ui.separator();
        asked = settings::show(ui, session).or(asked);
        ui.separator();
        result(ui, session);
        figures(ui, session, &mut asked);
        ui.separator();
        outputs(ui, &mut asked);
    });
    asked
}

/// The file's name and size.
fn file(ui: &mut Ui, session: &Session) {
    let Some(opened) = session.opened() else { return };
    let [width, height] = opened.size();
    ui.heading(opened.name());
    ui.label(RichText::new(format!("{width} × {height} pixels")).color(QUIET));
}

/// Which layers were found and why.
fn explanation(ui: &mut Ui, session: &Session) {
    for line in session.opened().map(|opened| opened.explanation()).unwrap_or_default() {
        ui.label(RichText::new(line).small().color(QUIET));
    }
}

/// The layer to denoise, if there is a choice.
fn color(ui: &mut Ui, session: &mut Session) {
    let Some(selection) = session.opened().and_then(|opened| opened.view().selection()) else {
        return;
    };
    if session.colors.len() < 2 {
        return;
    }
    let (found, mut chosen) = (selection.color.clone(), selection.color.clone());
    choice(ui, "Color", escaped(&found), |ui| {
        for name in &session.colors {
            ui.selectable_value(&mut chosen, name.clone(), escaped(name));
        }
    });
    if chosen != found {
        session.choose(Wish { color: Some(chosen), ..Wish::default() });
    }
}

/// The view to show, if there is a choice.
fn view(ui: &mut Ui, session: &mut Session) {
    let Some(opened) = session.opened().filter(|opened| opened.picture.views().len() > 1) else {
        return;
    };
    let (names, mut chosen) = (opened.views(), opened.shown);
    let (before, shown) = (chosen, names[chosen].clone());
    choice(ui, "View", shown, |ui| {
        for (i, name) in names.into_iter().enumerate() {
            ui.selectable_value(&mut chosen, i, name);
        }
    });
    if chosen != before {
        session.choose(Wish { view: chosen, ..session.wish.clone() });
    }
}

/// The position in the sequence, and the watch toggle.
fn sequence(ui: &mut Ui, session: &mut Session) -> Option<Action> {
    let mut watches = session.watch.is_some();
    if let Some((at, count)) = session.sequence.as_ref().map(|s| (s.at(), s.len()))
        && count > 1
    {
        let mut place = at + 1;
        ui.spacing_mut().slider_width = 150.0;
        let slider = Slider::new(&mut place, 1..=count).text(format!("of {count}"));
        if ui.add(slider).on_hover_text("arrow keys").changed() {
            commands::go(session, |sequence| sequence.go(place - 1));
        }
    }
    let hint = "W: open and denoise it again whenever it is written";
    let clicked = ui.checkbox(&mut watches, "Watch the file").on_hover_text(hint).clicked();
    clicked.then_some(Action::Watch)
}

/// Time, tiles and memory.
fn result(ui: &mut Ui, session: &mut Session) {
    if session.is_denoising() {
        ui.label(RichText::new("Denoising…").color(QUIET));
    } else if session.is_outdated() && ui.button("Denoise now").clicked() {
        session.denoise();
    }
    let Some(denoised) = &session.denoised else { return };
    let outcome = denoised;
    if session.is_outdated() {
        ui.label(
            RichText::new("The image shown was denoised with other settings").small().color(QUIET),
        );
    }
    let [whole, network] = [outcome.took, outcome.network_time].map(|time| time.as_secs_f64());
    ui.label(format!("Denoised in {whole:.2} s, {network:.2} s of it in the network"));
    let prepared = outcome.prepared.map(|time| {
        format!("after {:.2} s to compile kernels and load weights", time.as_secs_f64())
    });
    for line in prepared.iter().chain([&outcome.plan]).chain(&outcome.notices) {
        ui.label(RichText::new(line).small().color(QUIET));
    }
}

/// The error against the reference, and how noisy the images look.
fn figures(ui: &mut Ui, session: &Session, asked: &mut Option<Action>) {
    ui.separator();
    let misfit = session.misfit();
    if let Some(reference) = &session.reference {
        let text = misfit.clone().unwrap_or_else(|| format!("Reference: {}", reference.name()));
        ui.label(RichText::new(text).small().color(QUIET));
    }
    if session.reference.is_none() || misfit.is_some() {
        let hint = "R; or drop the file with Shift held";
        if ui.button("Compare with a reference…").on_hover_text(hint).clicked() {
            *asked = Some(Action::OpenReference);
        }
    }
    let flip = session.perceiving.found().map(|found| flip_row(found.means));
    let rows = session.figures.iter().flat_map(Figures::rows).chain(flip);
    let rows = rows.collect::<Vec<_>>();
    if rows.is_empty() {
        return;
    }
    Grid::new("figures").num_columns(3).striped(true).spacing([24.0, 5.0]).show(ui, |ui| {
        for heading in ["", "noisy", "denoised"] {
            ui.label(RichText::new(heading).color(QUIET));
        }
        ui.end_row();
        for row in rows {
            ui.label(row.name).on_hover_text(row.hint);
            ui.monospace(row.noisy);
            ui.monospace(row.denoised);
            ui.end_row();
        }
    });
}

fn outputs(ui: &mut Ui, asked: &mut Option<Action>) {
    for (text, hint, action) in [
        ("Save the result…", "Ctrl S: the file that the command line would write", Action::Save),
        (
            "Save the comparison…",
            "Ctrl Shift S: the picture that is shown, as PNG",
            Action::SaveComparison,
        ),
        ("Copy the command line", "Ctrl E: the command that does the same", Action::CopyCommand),
    ] {
        let button = Button::new(text).min_size([190.0, 0.0].into());
        if ui.add(button).on_hover_text(hint).clicked() {
            *asked = Some(action);
        }
    }
}
