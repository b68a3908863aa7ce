//! A camera that orbits its target and never leaves the room.

use std::f32::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

use glam::Vec3;
use path_tracer::renderer::camera::Camera;
use path_tracer::renderer::scene::{Scene, Shape};

/// Radians per pixel of a drag.
const TURN: f32 = 0.006;
/// Factor on the distance per step of the wheel.
const STEP: f32 = 0.9;
/// Largest angle above or below the horizon, just short of the pole.
const STEEPEST: f32 = FRAC_PI_2 - 0.05;
/// Distances from the target, in meters.
const DISTANCES: RangeInclusive<f32> = 0.2..=20.0;
/// The camera stops at this share of the distance to a wall.
const CLEARANCE: f32 = 0.95;

/// A camera in spherical coordinates around its target.
pub(super) struct Orbit {
    target: Vec3,
    field_of_view: f32,
    /// Angle around the y axis, from the z axis.
    azimuth: f32,
    /// Angle above the horizon.
    elevation: f32,
    /// Distance from the target if no wall is closer.
    distance: f32,
    walls: Vec<Wall>,
}

/// A parallelogram: a corner and the two edges that leave it.
#[derive(Clone, Copy)]
struct Wall {
    corner: Vec3,
    edges: [Vec3; 2],
}

impl Orbit {
    /// Starts at the scene's own camera. Every flat shape of the scene is a wall.
    pub(super) fn new(scene: &Scene) -> Self {
        let Camera { position, target, field_of_view } = scene.camera;
        let offset = position - target;
        let distance = offset.length();
        Self {
            target,
            field_of_view,
            azimuth: offset.x.atan2(offset.z),
            elevation: (offset.y / distance).asin(),
            distance,
            walls: scene.shapes.iter().filter_map(|(shape, _)| Wall::of(shape)).collect(),
        }
    }

    /// The current view. A wall between the target and the orbit moves the camera closer.
    pub(super) fn camera(&self) -> Camera {
        let position = self.target + self.reach() * self.direction();
        Camera { position, target: self.target, field_of_view: self.field_of_view }
    }

    /// Rotates by a mouse drag, in pixels to the right and down.
    pub(super) fn drag(&mut self, [x, y]: [f32; 2]) {
        self.azimuth -= x * TURN;
        self.elevation = (self.elevation + y * TURN).clamp(-STEEPEST, STEEPEST);
    }

    /// Moves closer by wheel steps, from the camera's current position.
    pub(super) fn zoom(&mut self, steps: f32) {
        let distance = self.reach() * STEP.powf(steps);
        self.distance = distance.clamp(*DISTANCES.start(), *DISTANCES.end());
    }

    /// From the target to the camera.
    fn direction(&self) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth, self.elevation);
        let across = elevation.cos();
        Vec3::new(across * azimuth.sin(), elevation.sin(), across * azimuth.cos())
    }

    /// The orbit's distance, or just short of the nearest wall.
    fn reach(&self) -> f32 {
        let direction = self.direction();
        let hits = self.walls.iter().filter_map(|wall| wall.hit(self.target, direction));
        hits.fold(self.distance, |reach, hit| reach.min(CLEARANCE * hit))
    }
}

impl Wall {
    fn of(shape: &Shape) -> Option<Self> {
        match *shape {
            Shape::Quad { corner, edges } => Some(Self { corner, edges }),
            Shape::Sphere { .. } | Shape::Triangle { .. } => None,
        }
    }

    /// Distance at which a ray hits the wall (Möller and Trumbore, as in `intersect.wgsl`).
    fn hit(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let [a, b] = self.edges;
        let p = direction.cross(b);
        let determinant = a.dot(p);
        let from_corner = origin - self.corner;
        let q = from_corner.cross(a);
        let [u, v, distance] =
            [from_corner.dot(p), direction.dot(q), b.dot(q)].map(|value| value / determinant);
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        (inside && distance > 0.0).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;
    use path_tracer::renderer::scenes::SceneName;

    use super::*;

    /// Whether the line segment between two points crosses a rectangle: the points are on
    /// different sides of its plane, and the line passes between opposite edges.
    fn crosses(from: Vec3, to: Vec3, corner: Vec3, edges: [Vec3; 2]) -> bool {
        let normal = edges[0].cross(edges[1]);
        let [before, after] = [from, to].map(|point| (point - corner).dot(normal));
        let crossing = from + (to - from) * (before / (before - after)) - corner;
        let within = |edge: Vec3| (0.0..=edge.length_squared()).contains(&crossing.dot(edge));
        before * after <= 0.0 && edges.into_iter().all(within)
    }

    fn hidden_by_a_wall(scene: &Scene, camera: &Camera) -> bool {
        scene.shapes.iter().any(|(shape, _)| match *shape {
            Shape::Quad { corner, edges } => crosses(camera.target, camera.position, corner, edges),
            Shape::Sphere { .. } | Shape::Triangle { .. } => false,
        })
    }

    /// Drags around every scene in steps of 12 pixels, at several distances and heights.
    #[test]
    fn no_wall_comes_between_the_camera_and_its_target() {
        for &name in SceneName::value_variants() {
            let scene = name.build();
            let mut walls = 0;
            for (zoom, height) in
                [-12.0, 0.0, 8.0].iter().flat_map(|z| (-20..20).map(move |h| (z, h)))
            {
                let mut orbit = Orbit::new(&scene);
                orbit.zoom(*zoom);
                orbit.drag([0.0, 12.0 * height as f32]);
                for _ in 0..90 {
                    orbit.drag([12.0, 0.0]);
                    let camera = orbit.camera();
                    assert!(!hidden_by_a_wall(&scene, &camera), "{name:?}: {camera:?}");
                    let free = orbit.target + orbit.distance * orbit.direction();
                    walls +=
                        usize::from(hidden_by_a_wall(&scene, &Camera { position: free, ..camera }));
                }
            }
            assert!(walls > 500, "{name:?}: only {walls} views needed the clamp");
        }
    }

    #[test]
    fn the_orbit_starts_at_the_camera_of_the_scene_and_returns_to_it_after_a_wall() {
        let scene = SceneName::StillLife.build();
        let mut orbit = Orbit::new(&scene);
        let off = |orbit: &Orbit| orbit.camera().position.distance(scene.camera.position);
        assert!(off(&orbit) < 1e-5);
        orbit.drag([0.0, -150.0]);
        assert!(orbit.reach() < 0.5 * orbit.distance, "the floor brings it closer");
        orbit.drag([0.0, 150.0]);
        assert!(off(&orbit) < 1e-5);
    }

    #[test]
    fn the_wheel_zooms_from_where_the_camera_is_and_stops_at_both_ends() {
        let mut orbit = Orbit::new(&SceneName::StillLife.build());
        orbit.drag([0.0, -150.0]);
        let close = orbit.reach();
        orbit.zoom(1.0);
        assert!((orbit.reach() - STEP * close).abs() < 1e-5);
        orbit.drag([0.0, 400.0]);
        for (steps, end) in [(1000.0, DISTANCES.start()), (-1000.0, DISTANCES.end())] {
            orbit.zoom(steps);
            assert_eq!(orbit.distance, *end);
        }
    }
}
