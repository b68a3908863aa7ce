//! Turning a camera around what it looks at.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;

use crate::renderer::camera::Camera;

/// Radians per pixel of a drag.
const TURN: f32 = 0.006;
/// What a step of the wheel leaves of the distance.
const STEP: f32 = 0.9;
/// Highest angle over the horizon, short of the pole.
const HIGHEST: f32 = FRAC_PI_2 - 0.05;

/// The camera after the mouse was dragged by so many pixels.
pub(super) fn drag(camera: &Camera, [x, y]: [f32; 2]) -> Camera {
    let offset = camera.position - camera.target;
    let distance = offset.length();
    let turned = offset.x.atan2(offset.z) - x * TURN;
    let height = ((offset.y / distance).asin() + y * TURN).clamp(-HIGHEST, HIGHEST);
    let across = height.cos();
    let direction = Vec3::new(across * turned.sin(), height.sin(), across * turned.cos());
    Camera { position: camera.target + distance * direction, ..*camera }
}

/// The camera after the wheel was turned by so many steps away from the hand.
pub(super) fn zoom(camera: &Camera, steps: f32) -> Camera {
    let offset = camera.position - camera.target;
    Camera { position: camera.target + offset * STEP.powf(steps), ..*camera }
}
