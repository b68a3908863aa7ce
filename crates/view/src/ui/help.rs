//! The table of keys, over the window.

use eframe::egui::{Align2, Context, Grid, RichText, ScrollArea, Ui, Window};

use crate::state::keys::BINDINGS;
use crate::ui::theme::ACCENT;

/// Shows the table of keys until it is closed. Small windows scroll it.
pub(crate) fn show(context: &Context, is_open: &mut bool) {
    const TITLE_AND_MARGINS: f32 = 90.0;
    let height = context.content_rect().height() - TITLE_AND_MARGINS;
    Window::new("Keys")
        .open(is_open)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            let area = ScrollArea::vertical().min_scrolled_height(height).max_height(height);
            area.show(ui, contents);
        });
}

fn contents(ui: &mut Ui) {
    let listed: Vec<_> = BINDINGS.iter().filter(|b| !b.help.is_empty()).collect();
    let rows = listed.len().div_ceil(2);
    Grid::new("keys").num_columns(4).spacing([16.0, 5.0]).show(ui, |ui| {
        for row in 0..rows {
            for binding in [Some(listed[row]), listed.get(row + rows).copied()] {
                let Some(binding) = binding else { continue };
                ui.label(RichText::new(binding.keys()).monospace().color(ACCENT));
                ui.label(binding.help);
            }
            ui.end_row();
        }
    });
    ui.separator();
    ui.label("Wheel or pinch: zoom to the cursor.  Drag: pan.  Double click: fit.");
    ui.label("Drop files to open them. Hold Shift to drop a reference.");
    ui.label("Drop a weights file, or a folder of Open Image Denoise's weights, to use it.");
}
