//! The camera.

use glam::{Quat, Vec3};

/// A pinhole camera, in meters; y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole.
    pub position: Vec3,
    /// The point at the center of the image.
    pub target: Vec3,
    /// Vertical angle of view in degrees, below 180.
    pub field_of_view: f32,
}

/// The image plane at distance 1: vectors from its center to its edges, and the view direction.
pub(super) struct ImagePlane {
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    pub(super) forward: Vec3,
}

impl Camera {
    /// Orbits the target to the right by this angle, in degrees.
    #[must_use]
    pub fn orbit(self, angle: f32) -> Self {
        let turn = Quat::from_rotation_y(angle.to_radians());
        Self { position: self.target + turn * (self.position - self.target), ..self }
    }

    pub(super) fn image_plane(&self, [width, height]: [u32; 2]) -> ImagePlane {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let half_height = (self.field_of_view.to_radians() / 2.0).tan();
        let half_width = half_height * width as f32 / height as f32;
        ImagePlane { right: right * half_width, up: right.cross(forward) * half_height, forward }
    }
}
