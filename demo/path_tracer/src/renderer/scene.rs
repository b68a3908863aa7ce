//! What a scene is made of. Metres, y is up; colours are linear.

use glam::Vec3;

use super::camera::Camera;

/// Shapes with materials under a sky.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) shapes: Vec<(Shape, usize)>,
    pub(crate) materials: Vec<Material>,
    pub(crate) sky: Sky,
    pub(crate) camera: Camera,
}

/// A surface. Its outside is where the edges, seen from there, turn counterclockwise; only that
/// side of an emitter shines.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    Sphere {
        centre: Vec3,
        radius: f32,
    },
    /// A corner and the two edges that leave it.
    Quad {
        corner: Vec3,
        edges: [Vec3; 2],
    },
    /// Corners and the unit normals there, between which shading interpolates.
    Triangle {
        corners: [Vec3; 3],
        normals: [Vec3; 3],
    },
}

/// How a surface scatters or sends light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Material {
    Diffuse(Vec3),
    /// Diffuse, of two colours in cells of this side.
    Checker {
        colors: [Vec3; 2],
        cell: f32,
    },
    /// The reflectance at a right angle, and the roughness from 0.05 to 1.
    Metal {
        color: Vec3,
        roughness: f32,
    },
    /// Smooth glass and what it lets through at each surface; the other side of its shape is its
    /// inside.
    Glass {
        color: Vec3,
        ior: f32,
    },
    /// Radiance of the front.
    Emitter(Vec3),
}

/// What is seen where nothing is: radiance at the horizon, which it keeps below, and above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sky {
    pub(crate) horizon: Vec3,
    pub(crate) zenith: Vec3,
    pub(crate) sun: Option<Sun>,
}

/// A round light so far away that it stands in one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sun {
    /// Towards it; any length.
    pub(crate) direction: Vec3,
    /// The angle that it fills, in degrees.
    pub(crate) angle: f32,
    pub(crate) radiance: Vec3,
}

impl Scene {
    /// An empty scene.
    pub(crate) fn new(camera: Camera, sky: Sky) -> Self {
        Self { shapes: Vec::new(), materials: Vec::new(), sky, camera }
    }

    /// The scene with shapes of one material more.
    #[must_use]
    pub(crate) fn with(
        mut self,
        material: Material,
        shapes: impl IntoIterator<Item = Shape>,
    ) -> Self {
        let index = self.materials.len();
        self.materials.push(material);
        self.shapes.extend(shapes.into_iter().map(|shape| (shape, index)));
        self
    }
}

impl Sky {
    /// The same radiance everywhere.
    pub(crate) fn constant(radiance: Vec3) -> Self {
        Self { horizon: radiance, zenith: radiance, sun: None }
    }
}
