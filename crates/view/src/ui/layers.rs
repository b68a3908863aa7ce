//! The further layers of light: which to denoise, and which to show.

use eframe::egui::{CollapsingHeader, Key, TextEdit, Ui};
use wgdenoise_files::{LayersWish, escaped};

use crate::open::Wish;
use crate::session::Session;
use crate::ui::theme::choice;

/// Shows the list, if the file has such layers. Ticking one reads the file again.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) {
    let selection = session.opened().and_then(|opened| opened.view().selection());
    let possible = selection.map(|selection| selection.possible_layers.clone()).unwrap_or_default();
    if possible.is_empty() {
        return;
    }
    let (before, chosen) = (session.wish.layers.clone(), possible.iter().filter(|l| l.1).count());
    let (mut wish, mut ticks) = (before.clone(), possible.clone());
    CollapsingHeader::new(format!("Further layers: {chosen} of {}", possible.len()))
        .id_salt("further layers")
        .default_open(possible.len() <= MOST_OPEN)
        .show(ui, |ui| {
            let mut is_auto = wish == Some(LayersWish::Auto);
            let hint = "light groups and passes that renderers add up to the color";
            if ui.checkbox(&mut is_auto, "find by name").on_hover_text(hint).clicked() {
                wish = is_auto.then_some(LayersWish::Auto);
            }
            let text = &mut session.patterns;
            if patterns(ui, text) {
                wish = (!text.trim().is_empty()).then(|| LayersWish::parse(text));
            }
            for (name, is_chosen) in &mut ticks {
                ui.checkbox(is_chosen, escaped(name));
            }
        });
    if ticks != possible {
        wish = named(&ticks);
    }
    if wish != before {
        session.choose(Wish { layers: wish, ..session.wish.clone() });
    }
    shown(ui, session);
}

/// A text field for names and patterns; returns whether Enter was pressed.
fn patterns(ui: &mut Ui, text: &mut String) -> bool {
    let line = TextEdit::singleline(text).desired_width(190.0).hint_text("light_*, key_?");
    let hint = "names or patterns, separated by commas, as for --layers; press Enter";
    let line = ui.add(line).on_hover_text(hint);
    line.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
}

/// Chooses the layer shown as the noisy and the denoised image.
fn shown(ui: &mut Ui, session: &mut Session) {
    let Some(opened) = session.opened().filter(|opened| !opened.view().layers().is_empty()) else {
        return;
    };
    let names: Vec<_> = opened.view().layers().iter().map(|layer| layer.name.clone()).collect();
    let chosen = &mut session.further.chosen;
    let name = |chosen: &Option<String>| chosen.as_ref().map_or("the color".into(), |n| escaped(n));
    // Another file may lack the layer.
    let present = chosen.clone().filter(|chosen| names.contains(chosen));
    choice(ui, "Shown", name(&present), |ui| {
        for layer in [None].into_iter().chain(names.into_iter().map(Some)) {
            let text = name(&layer);
            ui.selectable_value(chosen, layer, text);
        }
    });
}

/// Longer lists start collapsed.
const MOST_OPEN: usize = 8;

/// The wish for the ticked layers.
fn named(ticks: &[(String, bool)]) -> Option<LayersWish> {
    let names: Vec<_> = ticks.iter().filter(|tick| tick.1).map(|tick| tick.0.clone()).collect();
    (!names.is_empty()).then_some(LayersWish::Matching(names))
}
