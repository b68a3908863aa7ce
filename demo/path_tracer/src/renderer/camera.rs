//! Where the picture is taken from.

use glam::Vec3;

/// A pinhole camera; metres, y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Camera {
    pub(crate) position: Vec3,
    /// What is in the middle of the picture.
    pub(crate) target: Vec3,
    /// Angle between the bottom and the top of the picture, in degrees, below 180.
    pub(crate) field_of_view: f32,
}

/// The image plane at distance 1: from its middle to its edges, and towards it.
pub(super) struct ImagePlane {
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    pub(super) forward: Vec3,
}

impl Camera {
    pub(super) fn image_plane(&self, [width, height]: [u32; 2]) -> ImagePlane {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let half_height = (self.field_of_view.to_radians() / 2.0).tan();
        let half_width = half_height * width as f32 / height as f32;
        ImagePlane { right: right * half_width, up: right.cross(forward) * half_height, forward }
    }
}
