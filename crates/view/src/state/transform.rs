//! The image's placement in the window: zoom and center.
//!
//! Window positions are in physical pixels from the corner of the image area.

/// Minimum and maximum zoom, in screen pixels per image pixel.
const ZOOMS: [f32; 2] = [1.0 / 64.0, 64.0];

/// A position or a size.
pub(crate) type Vec2 = [f32; 2];

/// The placement of an image in the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    /// Screen pixels per image pixel.
    zoom: f32,
    /// Image position at the center of the area.
    center: Vec2,
    /// Whether the whole image stays visible when the window is resized.
    fits: bool,
}

impl Default for Transform {
    fn default() -> Self {
        Self { zoom: 1.0, center: [0.0; 2], fits: true }
    }
}

impl Transform {
    pub(crate) fn zoom(&self) -> f32 {
        self.zoom
    }

    /// Fits the whole image into the area, and keeps it fitted.
    pub(crate) fn fit(&mut self) {
        self.fits = true;
    }

    /// Sets one screen pixel per image pixel, around the same center.
    pub(crate) fn one_to_one(&mut self) {
        *self = Self { zoom: 1.0, fits: false, ..*self };
    }

    /// Adapts to the area's size. Call it before each use.
    pub(crate) fn lay_out(&mut self, image: [u32; 2], area: Vec2) {
        let size = image.map(|side| side.max(1) as f32);
        if self.fits {
            self.zoom = clamped((area[0] / size[0]).min(area[1] / size[1]));
            self.center = size.map(|side| side / 2.0);
        }
        self.center = [0, 1].map(|axis| self.center[axis].clamp(0.0, size[axis]));
    }

    /// Zooms around the cursor.
    pub(crate) fn zoom_at(&mut self, cursor: Vec2, factor: f32, area: Vec2) {
        if !factor.is_finite() || factor <= 0.0 {
            return;
        }
        let held = self.image_at(cursor, area);
        self.zoom = clamped(self.zoom * factor);
        self.fits = false;
        let offset = |axis: usize| (cursor[axis] - area[axis] / 2.0) / self.zoom;
        self.center = [0, 1].map(|axis| held[axis] - offset(axis));
    }

    /// Moves the image by this many screen pixels.
    pub(crate) fn pan(&mut self, by: Vec2) {
        self.center = [0, 1].map(|axis| self.center[axis] - by[axis] / self.zoom);
        self.fits = false;
    }

    /// The image position at a position of the area.
    pub(crate) fn image_at(&self, place: Vec2, area: Vec2) -> Vec2 {
        [0, 1].map(|axis| self.center[axis] + (place[axis] - area[axis] / 2.0) / self.zoom)
    }

    /// The image pixel at a position of the area, if any.
    pub(crate) fn pixel_at(&self, place: Vec2, area: Vec2, image: [u32; 2]) -> Option<[u32; 2]> {
        let at = self.image_at(place, area).map(f32::floor);
        let inside = |axis: usize| at[axis] >= 0.0 && at[axis] < image[axis] as f32;
        (inside(0) && inside(1)).then(|| at.map(|v| v as u32))
    }
}

fn clamped(zoom: f32) -> f32 {
    zoom.clamp(ZOOMS[0], ZOOMS[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: [u32; 2] = [400, 200];
    const AREA: Vec2 = [800.0, 800.0];

    fn laid_out() -> Transform {
        let mut transform = Transform::default();
        transform.lay_out(IMAGE, AREA);
        transform
    }

    #[test]
    fn a_fitting_image_touches_the_nearer_edges_and_follows_the_window() {
        let mut transform = laid_out();
        assert_eq!(transform.zoom(), 2.0);
        assert_eq!(transform.image_at([0.0, 200.0], AREA), [0.0, 0.0]);
        transform.lay_out(IMAGE, [100.0, 800.0]);
        assert_eq!(transform.zoom(), 0.25);
        transform.one_to_one();
        transform.lay_out(IMAGE, AREA);
        assert_eq!(transform.zoom(), 1.0);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_cursor() {
        let mut transform = laid_out();
        for factor in [1.7, 0.2, 3.0, 1000.0, 1e-9] {
            let before = transform.image_at([100.0, 300.0], AREA);
            transform.zoom_at([100.0, 300.0], factor, AREA);
            let after = transform.image_at([100.0, 300.0], AREA);
            let moved = [0, 1].map(|axis| (before[axis] - after[axis]).abs());
            assert!(moved[0] < 0.01 && moved[1] < 0.01, "{factor}: {moved:?}");
            assert!((ZOOMS[0]..=ZOOMS[1]).contains(&transform.zoom()));
        }
    }

    #[test]
    fn broken_factors_change_nothing() {
        for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let mut transform = laid_out();
            transform.zoom_at([1.0, 2.0], factor, AREA);
            assert_eq!(transform, laid_out());
        }
    }

    #[test]
    fn panning_moves_by_screen_pixels_and_never_loses_the_image() {
        let mut transform = laid_out();
        transform.pan([20.0, -10.0]);
        assert_eq!(transform.image_at([20.0, 190.0], AREA), [0.0, 0.0]);
        transform.pan([-1e7, 1e7]);
        transform.lay_out(IMAGE, AREA);
        assert_eq!(transform.image_at([400.0, 400.0], AREA), [400.0, 0.0]);
    }

    #[test]
    fn only_places_on_the_image_have_a_pixel() {
        let transform = laid_out();
        let at = |place| transform.pixel_at(place, AREA, IMAGE);
        assert_eq!(at([0.0, 200.0]), Some([0, 0]));
        assert_eq!(at([799.0, 599.0]), Some([399, 199]));
        assert_eq!((at([10.0, 199.0]), at([10.0, 600.0])), (None, None));
    }
}
