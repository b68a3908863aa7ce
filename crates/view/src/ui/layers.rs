//! The further layers of light to denoise along, as a list to tick.

use eframe::egui::{CollapsingHeader, Ui};
use wgdenoise_files::{LayersWish, escaped};

use crate::open::Wish;
use crate::session::Session;

/// Shows the list, if the file has such layers. Ticking one reads the file anew.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) {
    let selection = session.opened().and_then(|opened| opened.view().selection());
    let Some(possible) = selection.map(|s| &s.possible_layers).filter(|all| !all.is_empty()) else {
        return;
    };
    let (before, chosen) = (session.wish.layers.clone(), possible.iter().filter(|l| l.1).count());
    let (mut wish, mut ticks) = (before.clone(), possible.clone());
    CollapsingHeader::new(format!("Further layers: {chosen} of {}", possible.len()))
        .id_salt("further layers")
        .default_open(possible.len() <= MOST_OPEN)
        .show(ui, |ui| {
            let mut is_auto = wish == Some(LayersWish::Auto);
            let hint = "light groups and passes that renderers add up to the color";
            if ui.checkbox(&mut is_auto, "found by their names").on_hover_text(hint).clicked() {
                wish = is_auto.then_some(LayersWish::Auto);
            }
            for (name, is_chosen) in &mut ticks {
                ui.checkbox(is_chosen, escaped(name));
            }
        });
    if ticks != *possible {
        wish = named(&ticks);
    }
    if wish != before {
        session.choose(Wish { layers: wish, ..session.wish.clone() });
    }
}

/// Longer lists are shown when the user opens them.
const MOST_OPEN: usize = 8;

/// The wish for the layers with a tick.
fn named(ticks: &[(String, bool)]) -> Option<LayersWish> {
    let names: Vec<_> = ticks.iter().filter(|tick| tick.1).map(|tick| tick.0.clone()).collect();
    (!names.is_empty()).then_some(LayersWish::Matching(names))
}
