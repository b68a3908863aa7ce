//! Solids made of several shapes.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec3};

use super::scene::Shape;

/// The six faces of an axis-aligned box.
#[must_use]
pub fn cuboid(low: Vec3, high: Vec3) -> Vec<Shape> {
    let [x, y, z] = (high - low).to_array();
    let [x, y, z] = [Vec3::X * x, Vec3::Y * y, Vec3::Z * z];
    let at_low = [[y, x], [z, y], [x, z]].map(|edges| Shape::Quad { corner: low, edges });
    let at_high = [[-x, -y], [-y, -z], [-z, -x]].map(|edges| Shape::Quad { corner: high, edges });
    at_low.into_iter().chain(at_high).collect()
}

/// A torus around the z axis, with the radii of its ring and its tube.
#[must_use]
pub fn torus(ring: f32, tube: f32, transform: Affine3A) -> Vec<Shape> {
    const RING_STEPS: u32 = 72;
    const TUBE_STEPS: u32 = 36;
    let vertex = |i: u32, j: u32| {
        let (around, across) = (turn(i, RING_STEPS), turn(j, TUBE_STEPS));
        let outwards = Vec3::new(around.cos(), around.sin(), 0.0);
        let normal = outwards * across.cos() + Vec3::Z * across.sin();
        (transform.transform_point3(outwards * ring + normal * tube), normal)
    };
    let cells = (0..RING_STEPS).flat_map(|i| (0..TUBE_STEPS).map(move |j| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
        [[a, b, c], [a, c, d]]
    });
    halves
        .map(|vertices| Shape::Triangle {
            corners: vertices.map(|(position, _)| position),
            normals: vertices.map(|(_, n)| transform.transform_vector3(n).normalize()),
        })
        .collect()
}

/// The angle of a step; the last equals the first exactly, to close the seam.
fn turn(step: u32, of: u32) -> f32 {
    (step % of) as f32 / of as f32 * TAU
}

/// A faceted ball around the origin: an icosahedron whose faces are divided into four `cuts` times.
#[must_use]
pub fn icosphere(radius: f32, cuts: u32, transform: Affine3A) -> Vec<Shape> {
    let faces = (0..cuts).fold(icosahedron(), |faces, _| faces.into_iter().flat_map(cut).collect());
    let facet = |corners: [Vec3; 3]| {
        let corners = corners.map(|corner| transform.transform_point3(corner * radius));
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        Shape::Triangle { corners, normals: [normal; 3] }
    };
    faces.into_iter().map(facet).collect()
}

/// Divides a face into four and moves the new corners onto the unit sphere.
fn cut([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 4] {
    let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// A top, two rings of five corners and a bottom, on the unit sphere.
fn icosahedron() -> Vec<[Vec3; 3]> {
    let height = 0.2_f32.sqrt();
    let ring = |step: u32, y: f32, shift: f32| {
        let angle = ((step % 5) as f32 + shift) / 5.0 * TAU;
        Vec3::new(angle.sin() * 2.0 * height, y, angle.cos() * 2.0 * height)
    };
    let around = |i: u32| {
        let (upper, next_upper) = (ring(i, height, 0.0), ring(i + 1, height, 0.0));
        let (lower, next_lower) = (ring(i, -height, 0.5), ring(i + 1, -height, 0.5));
        [
            [Vec3::Y, upper, next_upper],
            [upper, lower, next_upper],
            [next_upper, lower, next_lower],
            [lower, Vec3::NEG_Y, next_lower],
        ]
    };
    (0..5).flat_map(around).collect()
}
