//! Mouse and key state.

use winit::event::MouseScrollDelta;

use super::present::Split;
use crate::args::Args;

/// The user's choices.
pub(super) struct Controls {
    /// Whether the spheres move.
    pub(super) animate: bool,
    /// Whether frames are averaged along their motion.
    pub(super) temporal: bool,
    denoise: bool,
    /// Position of the divider as a share of the width; `None` if hidden.
    divider: Option<f32>,
    /// Position of the mouse in pixels.
    mouse: [f32; 2],
    drag: Option<Drag>,
}

/// What a drag moves.
#[derive(Clone, Copy)]
enum Drag {
    Camera,
    Divider,
}

/// Distance in pixels at which the mouse grabs the divider.
const GRASP: f32 = 12.0;

/// Pixels of touchpad scrolling per step of the wheel.
const WHEEL_STEP: f32 = 40.0;

impl Controls {
    pub(super) fn new(args: &Args) -> Self {
        Self {
            animate: args.animate,
            temporal: true,
            denoise: true,
            divider: None,
            mouse: [0.0; 2],
            drag: None,
        }
    }

    /// Handles a letter key.
    pub(super) fn press(&mut self, key: &str) {
        match key {
            "a" | "A" => self.animate = !self.animate,
            "t" | "T" => self.temporal = !self.temporal,
            "d" | "D" => self.denoise = !self.denoise,
            "s" | "S" => self.divider = self.divider.is_none().then_some(0.5),
            _ => {}
        }
    }

    /// Starts a drag in a window of this width.
    pub(super) fn grasp(&mut self, width: f32) {
        let near = |share: f32| (share * width - self.mouse[0]).abs() < GRASP;
        let divider = self.divider.filter(|_| self.denoise).is_some_and(near);
        self.drag = Some(if divider { Drag::Divider } else { Drag::Camera });
    }

    /// Ends the drag.
    pub(super) fn release(&mut self) {
        self.drag = None;
    }

    /// Moves the mouse; returns the pixels by which it drags the camera.
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

    /// How a window of this width is split: noisy left of the divider, or without one all noisy or
    /// all denoised.
    pub(super) fn split(&self, width: f32) -> Split {
        let noisy = if self.denoise { self.divider.unwrap_or(0.0) } else { 1.0 };
        Split { divider: noisy * width, marked: self.denoise && self.divider.is_some() }
    }
}

/// Wheel steps; positive ones move closer.
pub(super) fn steps(delta: MouseScrollDelta) -> f32 {
    match delta {
        MouseScrollDelta::LineDelta(_, lines) => lines,
        MouseScrollDelta::PixelDelta(by) => by.y as f32 / WHEEL_STEP,
    }
}
