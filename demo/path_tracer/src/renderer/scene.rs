//! Scenes, in meters; y is up and colors are linear.

use glam::Vec3;

use super::camera::Camera;

/// Shapes with materials, a sky and a camera.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Every shape with the index of its material.
    pub shapes: Vec<(Shape, usize)>,
    /// The materials.
    pub materials: Vec<Material>,
    /// The background.
    pub sky: Sky,
    /// The initial view.
    pub camera: Camera,
}

/// A surface. Edges and corners run counterclockwise as seen from outside; emitters emit only
/// outward.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Its center.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
    /// A parallelogram.
    Quad {
        /// One of its corners.
        corner: Vec3,
        /// The two edges that leave the corner.
        edges: [Vec3; 2],
    },
    /// A triangle of a smooth mesh.
    Triangle {
        /// Its corners.
        corners: [Vec3; 3],
        /// Unit normals at the corners; shading interpolates between them.
        normals: [Vec3; 3],
    },
}

/// How a surface scatters or emits light.
#[derive(Clone, Copy, Debug)]
pub enum Material {
    /// Lambertian, with this reflectance.
    Diffuse(Vec3),
    /// Lambertian, in a checkerboard.
    Checker {
        /// Reflectances of the two kinds of cell.
        colors: [Vec3; 2],
        /// Side of a cell.
        cell: f32,
    },
    /// GGX metal.
    Metal {
        /// Reflectance at normal incidence.
        color: Vec3,
        /// From 0.05 to 1.
        roughness: f32,
    },
    /// Smooth glass that fills its shape.
    Glass {
        /// Transmittance of each surface.
        color: Vec3,
        /// Index of refraction.
        ior: f32,
    },
    /// A light of this radiance.
    Emitter(Vec3),
}

/// The background: radiance that changes from the horizon to the zenith, and a sun.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    /// Radiance at the horizon and below.
    pub horizon: Vec3,
    /// Radiance at the zenith.
    pub zenith: Vec3,
    /// The sun, if it is up.
    pub sun: Option<Sun>,
}

/// A disc of light at infinity.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    /// Direction towards the sun, of any length.
    pub direction: Vec3,
    /// Angular diameter in degrees.
    pub angle: f32,
    /// Its radiance.
    pub radiance: Vec3,
}

impl Scene {
    /// An empty scene.
    #[must_use]
    pub fn new(camera: Camera, sky: Sky) -> Self {
        Self { shapes: Vec::new(), materials: Vec::new(), sky, camera }
    }

    /// Adds shapes of one material.
    #[must_use]
    pub fn with(mut self, material: Material, shapes: impl IntoIterator<Item = Shape>) -> Self {
        let index = self.materials.len();
        self.materials.push(material);
        self.shapes.extend(shapes.into_iter().map(|shape| (shape, index)));
        self
    }
}

impl Shape {
    /// The displacement from `other`, if the shape has only been moved.
    pub(super) fn moved_from(&self, other: &Self) -> Vec3 {
        self.anchor() - other.anchor()
    }

    /// The point that represents the shape's position.
    fn anchor(&self) -> Vec3 {
        match *self {
            Self::Sphere { center: at, .. }
            | Self::Quad { corner: at, .. }
            | Self::Triangle { corners: [at, ..], .. } => at,
        }
    }
}

impl Sky {
    /// A sky with the same radiance everywhere and no sun.
    #[must_use]
    pub fn constant(radiance: Vec3) -> Self {
        Self { horizon: radiance, zenith: radiance, sun: None }
    }
}
