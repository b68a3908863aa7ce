//! The image area: zoom, pan, and the line between two images.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Response, Sense, Ui, pos2, vec2,
};
use eframe::egui_wgpu::Callback;
use wgdenoise_files::escaped;

use crate::gpu::screen::{Draw, Kind, View};
use crate::session::Session;
use crate::state::looking::{Layout, Shown};
use crate::state::tone::Curve;

/// How close the cursor must be to grab the line, in points.
const GRIP: f32 = 7.0;

/// Distance of a label's text from the edge, in points.
const LABEL: f32 = 16.0;

/// Wheel travel, in points, that zooms by a factor of e.
const WHEEL: f32 = 220.0;

/// Shows the images and lets the user move them.
pub(crate) fn show(ui: &mut Ui, session: &mut Session) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let Some(size) = session.opened().map(|opened| opened.size()) else { return };
    let place = Place { rect, scale: ui.pixels_per_point(), layout: session.looking.layout };
    session.area = place.area();
    let before = session.transform.zoom();
    session.transform.lay_out(size, session.area);
    drag(ui, &response, session, &place);
    zoom(ui, &response, session, &place);
    session.transform.lay_out(size, session.area);
    if session.transform.zoom() != before {
        // The toolbar has already drawn the old value.
        ui.ctx().request_repaint();
    }
    let pointed = response.hover_pos().map(|at| place.within(at));
    session.pointed = pointed.and_then(|at| session.transform.pixel_at(at, session.area, size));
    if let Some(draw) = draw(session, &place) {
        ui.painter().add(Callback::new_paint_callback(rect, draw));
    }
    let painter = ui.painter_at(rect);
    labels(&painter, session, &place);
}

/// The image area's placement in the window.
struct Place {
    rect: Rect,
    /// Pixels per point.
    scale: f32,
    layout: Layout,
}

impl Place {
    /// Size of one view of the image, in pixels.
    fn area(&self) -> [f32; 2] {
        let size = self.rect.size() * self.scale;
        let columns = if self.layout == Layout::SideBySide { size.x / 2.0 } else { size.x };
        [columns.max(1.0), size.y.max(1.0)]
    }

    /// Converts a window position to pixels of the view under it.
    fn within(&self, at: Pos2) -> [f32; 2] {
        let offset = (at - self.rect.min) * self.scale;
        let [columns, _] = self.area();
        let is_right = self.layout == Layout::SideBySide && offset.x >= columns;
        [if is_right { offset.x - columns } else { offset.x }, offset.y]
    }

    /// The column of the line, in window points.
    fn line(&self, split: f32) -> f32 {
        let part = if self.layout == Layout::SideBySide { 0.5 } else { split };
        self.rect.left() + part * self.rect.width()
    }
}

/// Drags the line if it was grabbed, otherwise the image.
fn drag(ui: &Ui, response: &Response, session: &mut Session, place: &Place) {
    let line = place.line(session.looking.split);
    let holds = |at: Option<Pos2>| {
        place.layout == Layout::Split && at.is_some_and(|at| (at.x - line).abs() < GRIP)
    };
    if holds(response.hover_pos()) {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if response.drag_started() {
        let origin = ui.input(|input| input.pointer.press_origin());
        session.drags_line = holds(origin);
    }
    if response.dragged() {
        let at = response.interact_pointer_pos();
        match at.filter(|_| session.drags_line) {
            Some(at) => {
                let part = (at.x - place.rect.left()) / place.rect.width().max(1.0);
                session.looking.move_split(part);
            }
            None => session.transform.pan((response.drag_delta() * place.scale).into()),
        }
    }
    if response.double_clicked() {
        session.transform.fit();
    }
}

fn zoom(ui: &Ui, response: &Response, session: &mut Session, place: &Place) {
    let Some(at) = response.hover_pos() else { return };
    let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    let factor = (wheel / WHEEL).exp() * pinch;
    if factor != 1.0 {
        session.transform.zoom_at(place.within(at), factor, session.area);
    }
}

/// Collects what the shader needs; `None` while an image is missing.
fn draw(session: &Session, place: &Place) -> Option<Draw> {
    let visible = session.looking.visible(session.available());
    let texture = |shown| session.texture(shown).cloned();
    let images = [texture(visible[0])?, texture(visible[1])?, texture(session.subtracted())?];
    let size = session.opened()?.size().map(|side| side as f32);
    let whole = place.rect.size() * place.scale;
    let middle = session.area.map(|side| side / 2.0);
    let view = View {
        area: whole.into(),
        center: session.transform.image_at(middle, session.area),
        size,
        kinds: visible.map(|shown| Kind::of(shown, session.perceived().is_some()) as u32),
        zoom: session.transform.zoom(),
        gain: session.tone.gain(),
        amplification: session.looking.amplification,
        split: (place.line(session.looking.split) - place.rect.left()) * place.scale,
        curve: u32::from(session.tone.curve == Curve::Filmic),
        halves: u32::from(place.layout == Layout::SideBySide),
        encodes: 0,
        padding: 0,
    };
    Some(Draw { view, images })
}

/// Draws the line between two images, and their names.
fn labels(painter: &Painter, session: &Session, place: &Place) {
    let available = session.available();
    let [left, right] = session.looking.visible(available);
    let top = place.rect.top() + LABEL - 4.0;
    if place.layout == Layout::Single {
        let at = pos2(place.rect.left() + LABEL, top);
        label(painter, at, Align2::LEFT_TOP, &name(session, right));
        return;
    }
    let line = place.line(session.looking.split);
    painter.vline(line, place.rect.y_range(), (1.5, Color32::from_white_alpha(210)));
    if place.layout == Layout::Split {
        painter.circle_filled(pos2(line, place.rect.center().y), 5.0, Color32::WHITE);
    }
    label(painter, pos2(line - LABEL, top), Align2::RIGHT_TOP, &name(session, left));
    label(painter, pos2(line + LABEL, top), Align2::LEFT_TOP, &name(session, right));
}

fn name(session: &Session, shown: Shown) -> String {
    if let (Shown::Noisy | Shown::Denoised, Some(layer)) = (shown, session.layer()) {
        return format!("{}: {}", shown.name(), escaped(layer.name()));
    }
    match shown {
        Shown::Difference if session.perceived().is_some() => {
            "FLIP error: 0 black, 1 pale yellow".into()
        }
        Shown::Difference => {
            let other = session.subtracted().name().to_lowercase();
            let later = if session.wants_perceived() { "; computing FLIP…" } else { "" };
            format!("Difference from {other}, {:.0}×{later}", session.looking.amplification)
        }
        shown => shown.name().into(),
    }
}

/// Draws text that is legible on any image.
fn label(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    let font = FontId::proportional(13.0);
    let text = painter.layout_no_wrap(text.into(), font, Color32::from_gray(235));
    let rect = anchor.anchor_size(at, text.size());
    painter.rect_filled(rect.expand2(vec2(7.0, 3.0)), 4.0, Color32::from_black_alpha(150));
    painter.galley(rect.min, text, Color32::WHITE);
}
