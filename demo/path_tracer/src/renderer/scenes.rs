//! The built-in scenes.

use std::f32::consts::{FRAC_PI_2, TAU};

use clap::ValueEnum;
use glam::{Affine3A, Quat, Vec3, vec3};

use super::camera::Camera;
use super::meshes::{cuboid, icosphere, torus};
use super::scene::{Material, Scene, Shape, Sky, Sun};

/// The built-in scenes by name.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SceneName {
    /// Every material in the corner of a room
    StillLife,
    /// Tiny, very bright lights and rough metal: hard for a denoiser
    Fireflies,
    /// Light focused by glass onto a diffuse floor
    Caustics,
    /// Sunlit objects against an empty background
    Sky,
}

const GLASS: Material = Material::Glass { color: Vec3::ONE, ior: 1.5 };
const GOLD: Vec3 = vec3(1.0, 0.77, 0.34);
const SILVER: Vec3 = vec3(0.96, 0.95, 0.93);
const COPPER: Vec3 = vec3(0.95, 0.64, 0.54);

/// Period of a moving sphere in seconds, after which the scene repeats.
pub const PERIOD: f32 = 4.0;

impl SceneName {
    /// Builds the scene at rest.
    #[must_use]
    pub fn build(self) -> Scene {
        self.at(0.0)
    }

    /// Builds the scene as it is this many seconds after its spheres began to move. It always has
    /// the same shapes and materials, in the same order.
    #[must_use]
    pub fn at(self, time: f32) -> Scene {
        match self {
            Self::StillLife => still_life(time),
            Self::Fireflies => fireflies(time),
            Self::Caustics => caustics(time),
            Self::Sky => sky(time),
        }
    }
}

fn still_life(time: f32) -> Scene {
    let glass = swing(vec3(0.62, 0.42, 0.25), vec3(0.3, 0.0, 0.8), time);
    let silver = swing(vec3(1.15, 0.5, -0.75), vec3(0.0, 0.7, 0.0), time);
    let red = swing(vec3(-0.55, 0.24, 0.62), vec3(-0.9, 0.0, 0.4), time);
    let lean = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(-0.25);
    let ring = Affine3A::from_rotation_translation(lean, vec3(-0.62, 0.91, -0.45));
    let tilt = Quat::from_rotation_x(0.3);
    let gem = Affine3A::from_rotation_translation(tilt, vec3(0.05, 0.22, 0.95));
    let block = cuboid(vec3(-1.15, 0.0, -0.85), vec3(-0.15, 0.42, -0.05));
    room()
        .with(Material::Diffuse(vec3(0.78, 0.76, 0.72)), block)
        .with(Material::Metal { color: GOLD, roughness: 0.3 }, torus(0.36, 0.13, ring))
        .with(GLASS, [sphere(glass, 0.42)])
        .with(Material::Metal { color: SILVER, roughness: 0.12 }, [sphere(silver, 0.5)])
        .with(Material::Diffuse(vec3(0.72, 0.22, 0.12)), [sphere(red, 0.24)])
        .with(Material::Diffuse(vec3(0.15, 0.27, 0.62)), icosphere(0.22, 1, gem))
        .with(Material::Emitter(vec3(26.0, 15.0, 6.0)), [sphere(vec3(0.1, 0.09, -0.25), 0.09)])
}

/// A corner with a checkered floor, lit by a window on the right.
fn room() -> Scene {
    let camera = Camera {
        position: vec3(0.5, 1.35, 4.3),
        target: vec3(0.05, 0.62, 0.0),
        field_of_view: 32.0,
    };
    let tiles = [vec3(0.62, 0.55, 0.46), vec3(0.30, 0.22, 0.17)];
    let window = panel(vec3(2.6, 2.3, 1.6), vec3(0.0, 0.3, 0.0), [1.5, 1.5]);
    Scene::new(camera, Sky::constant(vec3(0.10, 0.12, 0.16)))
        .with(Material::Checker { colors: tiles, cell: 0.5 }, [floor(4.0)])
        .with(Material::Diffuse(vec3(0.72, 0.70, 0.66)), [wall_behind(-1.7, 4.0, 3.2)])
        .with(Material::Diffuse(vec3(0.16, 0.36, 0.38)), [wall_left(-2.1, 4.0, 3.2)])
        .with(Material::Emitter(vec3(13.0, 11.5, 9.5)), [window])
}

fn fireflies(time: f32) -> Scene {
    let left = swing(vec3(-1.1, 0.4, 0.1), vec3(0.0, 0.0, 0.9), time);
    let right = swing(vec3(1.1, 0.4, -0.2), vec3(0.0, 0.5, 0.0), time);
    let glass = swing(vec3(0.55, 0.22, 0.95), vec3(-1.0, 0.0, 0.3), time);
    let camera =
        Camera { position: vec3(0.0, 1.6, 5.0), target: vec3(0.0, 0.6, 0.0), field_of_view: 32.0 };
    let lamp = |step: u32| {
        let angle = step as f32 / 7.0 * TAU + 0.4;
        sphere(vec3(1.5 * angle.cos(), 0.5 + 0.13 * step as f32, 1.1 * angle.sin()), 0.018)
    };
    let upright =
        Affine3A::from_rotation_translation(Quat::from_rotation_y(0.6), vec3(0.0, 0.62, 0.0));
    Scene::new(camera, Sky::constant(vec3(0.004, 0.006, 0.012)))
        .with(Material::Diffuse(vec3(0.35, 0.33, 0.32)), [floor(6.0)])
        .with(Material::Metal { color: COPPER, roughness: 0.45 }, [wall_behind(-2.0, 6.0, 4.0)])
        .with(Material::Metal { color: GOLD, roughness: 0.35 }, torus(0.45, 0.17, upright))
        .with(
            Material::Metal { color: SILVER, roughness: 0.25 },
            [sphere(left, 0.4), sphere(right, 0.4)],
        )
        .with(GLASS, [sphere(glass, 0.22)])
        .with(Material::Emitter(vec3(1100.0, 650.0, 250.0)), (0..7).map(lamp))
}

fn caustics(time: f32) -> Scene {
    let ball = swing(vec3(0.75, 0.5, 0.2), vec3(0.5, 0.0, 0.5), time);
    let camera =
        Camera { position: vec3(0.0, 2.6, 4.2), target: vec3(0.0, 0.25, 0.0), field_of_view: 32.0 };
    let upright = Affine3A::from_rotation_translation(
        Quat::from_rotation_x(FRAC_PI_2),
        vec3(-0.75, 0.17, 0.3),
    );
    let gem = Affine3A::from_translation(vec3(0.1, 0.42, -0.75));
    let green = Material::Glass { color: vec3(0.75, 0.95, 0.8), ior: 1.5 };
    Scene::new(camera, Sky::constant(vec3(0.05, 0.06, 0.08)))
        .with(Material::Diffuse(vec3(0.7, 0.68, 0.64)), [floor(20.0)])
        .with(GLASS, [sphere(ball, 0.5)])
        .with(green, torus(0.45, 0.16, upright))
        .with(Material::Glass { color: vec3(0.8, 0.88, 1.0), ior: 1.8 }, icosphere(0.42, 0, gem))
        .with(Material::Emitter(vec3(120.0, 108.0, 90.0)), [sphere(vec3(-1.8, 3.2, -1.6), 0.25)])
}

fn sky(time: f32) -> Scene {
    let yellow = swing(vec3(-0.95, 0.5, -0.1), vec3(0.0, 0.8, 0.0), time);
    let camera =
        Camera { position: vec3(0.0, 0.9, 5.2), target: vec3(0.0, 0.95, 0.0), field_of_view: 34.0 };
    let sun =
        Sun { direction: vec3(-0.6, 0.8, 0.5), angle: 2.0, radiance: vec3(2400.0, 2200.0, 1900.0) };
    let sky = Sky { horizon: vec3(0.5, 0.6, 0.75), zenith: vec3(0.12, 0.26, 0.62), sun: Some(sun) };
    let ring =
        Affine3A::from_rotation_translation(Quat::from_rotation_y(-0.5), vec3(0.9, 0.75, -0.3));
    let ball = Affine3A::from_translation(vec3(-0.15, 0.33, 0.8));
    Scene::new(camera, sky)
        .with(
            Material::Checker { colors: [vec3(0.5, 0.48, 0.44), vec3(0.2, 0.24, 0.2)], cell: 0.4 },
            cuboid(vec3(-1.8, -0.25, -1.4), vec3(1.8, 0.0, 1.4)),
        )
        .with(Material::Metal { color: COPPER, roughness: 0.2 }, torus(0.55, 0.2, ring))
        .with(Material::Diffuse(vec3(0.75, 0.6, 0.15)), [sphere(yellow, 0.5)])
        .with(GLASS, icosphere(0.33, 2, ball))
}

/// A point that moves from `start` by `by` and back; it slows down at both ends.
fn swing(start: Vec3, by: Vec3, time: f32) -> Vec3 {
    start + by * (1.0 - (TAU * time / PERIOD).cos()) / 2.0
}

fn sphere(center: Vec3, radius: f32) -> Shape {
    Shape::Sphere { center, radius }
}

/// A floor at height 0 that extends this far in each direction.
fn floor(reach: f32) -> Shape {
    let edges = [Vec3::Z * 2.0 * reach, Vec3::X * 2.0 * reach];
    Shape::Quad { corner: vec3(-reach, 0.0, -reach), edges }
}

/// A wall across the view.
fn wall_behind(z: f32, reach: f32, height: f32) -> Shape {
    let edges = [Vec3::X * 2.0 * reach, Vec3::Y * height];
    Shape::Quad { corner: vec3(-reach, 0.0, z), edges }
}

/// A wall along the view.
fn wall_left(x: f32, reach: f32, height: f32) -> Shape {
    let edges = [Vec3::Y * height, Vec3::Z * 2.0 * reach];
    Shape::Quad { corner: vec3(x, 0.0, -reach), edges }
}

/// A rectangle centered on `center` that faces `target`.
fn panel(center: Vec3, target: Vec3, [width, height]: [f32; 2]) -> Shape {
    let normal = (target - center).normalize();
    let across = Vec3::Y.cross(normal).normalize();
    let edges = [across * width, normal.cross(across) * height];
    Shape::Quad { corner: center - (edges[0] + edges[1]) / 2.0, edges }
}
