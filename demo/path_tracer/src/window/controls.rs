//! What mouse and keys have set.

use winit::event::MouseScrollDelta;

use super::present::Split;

/// The state of mouse and keys.
pub(super) struct Controls {
    denoise: bool,
    /// Where the divider is, as a share of the width, if there is one.
    divider: Option<f32>,
    /// The mouse, in pixels.
    mouse: [f32; 2],
    drag: Option<Drag>,
}

/// What the pressed mouse moves.
#[derive(Clone, Copy)]
enum Drag {
    Camera,
    Divider,
}

/// How near to the divider the mouse grasps it, in pixels.
const GRASP: f32 = 12.0;

/// Pixels of a touchpad's scrolling that count as a step of a wheel.
const WHEEL_STEP: f32 = 40.0;

impl Default for Controls {
    fn default() -> Self {
        Self { denoise: true, divider: None, mouse: [0.0; 2], drag: None }
    }
}

impl Controls {
    /// A key with a letter was pressed.
    pub(super) fn press(&mut self, key: &str) {
        match key {
            "d" | "D" => self.denoise = !self.denoise,
            "s" | "S" => self.divider = self.divider.is_none().then_some(0.5),
            _ => {}
        }
    }

    /// The mouse was pressed in a window of this width.
    pub(super) fn grasp(&mut self, width: f32) {
        let near = |share: f32| (share * width - self.mouse[0]).abs() < GRASP;
        let divider = self.divider.filter(|_| self.denoise).is_some_and(near);
        self.drag = Some(if divider { Drag::Divider } else { Drag::Camera });
    }

    /// The mouse was let go.
    pub(super) fn release(&mut self) {
        self.drag = None;
    }

    /// The mouse was moved; returns by how many pixels it drags the camera.
    pub(super) fn move_to(&mut self, now: [f32; 2], width: f32) -> Option<[f32; 2]> {
        let before = std::mem::replace(&mut self.mouse, now);
        match self.drag? {
            Drag::Camera => Some([now[0] - before[0], now[1] - before[1]]),
            Drag::Divider => {
                self.divider = Some((now[0] / width).clamp(0.0, 1.0));
                None
            }
        }
    }

    /// What is to be seen in a window of this width: the noisy image up to the divider, or without
    /// one all of it or nothing.
    pub(super) fn split(&self, width: f32) -> Split {
        let noisy = if self.denoise { self.divider.unwrap_or(0.0) } else { 1.0 };
        Split { divider: noisy * width, marked: self.denoise && self.divider.is_some() }
    }
}

/// Steps of a wheel, away from the hand.
pub(super) fn steps(delta: MouseScrollDelta) -> f32 {
    match delta {
        MouseScrollDelta::LineDelta(_, lines) => lines,
        MouseScrollDelta::PixelDelta(by) => by.y as f32 / WHEEL_STEP,
    }
}
