//! The window's colors and sizes.

use eframe::egui::style::ScrollStyle;
use eframe::egui::{
    Color32, ComboBox, Context, CornerRadius, FontId, Margin, Stroke, TextStyle, Theme, Ui, Visuals,
};

/// Marks what is selected or running.
pub(crate) const ACCENT: Color32 = Color32::from_rgb(255, 176, 84);
/// Errors.
pub(crate) const ALARM: Color32 = Color32::from_rgb(255, 118, 104);
/// Explanations.
pub(crate) const QUIET: Color32 = Color32::from_rgb(150, 152, 158);

/// Width of the panel's name column, so that its tables line up.
pub(crate) const NAMES: f32 = 66.0;

/// A drop-down list with its name before it.
pub(crate) fn choice<R>(ui: &mut Ui, name: &str, chosen: String, list: impl FnOnce(&mut Ui) -> R) {
    ui.horizontal(|ui| {
        let label = ui.label(name);
        let list =
            ComboBox::from_id_salt(name).selected_text(chosen).width(180.0).show_ui(ui, list);
        list.response.labelled_by(label.id);
    });
}

/// Applies a dark, neutral theme that does not tint the images.
pub(crate) fn apply(context: &Context) {
    context.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_gray(30);
    visuals.window_fill = Color32::from_gray(36);
    visuals.extreme_bg_color = Color32::from_gray(20);
    visuals.override_text_color = Some(Color32::from_gray(222));
    visuals.selection.bg_fill = Color32::from_rgb(112, 74, 28);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    for widget in [
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
        &mut visuals.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
    }
    context.set_visuals_of(Theme::Dark, visuals);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = [8.0, 6.0].into();
        style.spacing.button_padding = [8.0, 4.0].into();
        style.spacing.window_margin = Margin::same(12);
        // Without a bar, nothing shows that the panel scrolls.
        style.spacing.scroll = ScrollStyle::thin();
        let sizes = [
            (TextStyle::Small, 11.5),
            (TextStyle::Body, 13.5),
            (TextStyle::Button, 13.5),
            (TextStyle::Heading, 17.0),
        ];
        for (text, size) in sizes {
            style.text_styles.insert(text, FontId::proportional(size));
        }
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.5));
    });
}
