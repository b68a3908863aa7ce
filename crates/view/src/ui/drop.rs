//! Feedback while a file is dragged over the window.

use eframe::egui::{Align2, Color32, Context, FontId, Id, LayerId, Order, Stroke, StrokeKind};

use crate::ui::theme::ACCENT;

/// Shows the drop hint while a file hovers.
pub(crate) fn show(context: &Context) {
    if context.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let painter = context.layer_painter(LayerId::new(Order::Foreground, Id::unique("drop")));
    let rect = context.content_rect();
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(170));
    let inner = rect.shrink(12.0);
    painter.rect_stroke(inner, 8.0, Stroke::new(2.0, ACCENT), StrokeKind::Inside);
    let text = "Drop to open; hold Shift to drop a reference";
    let font = FontId::proportional(22.0);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, font, Color32::WHITE);
}
