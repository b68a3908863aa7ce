//! The scene's buffers, laid out as in `shaders/scene.wgsl`.

use bytemuck::{NoUninit, Pod, Zeroable};
use glam::Vec3;
use wgpu::util::DeviceExt as _;

use super::Method;
use super::bvh::{Bounds, Bvh};
use super::scene::{Material, Scene, Shape, Sky};

/// The buffers, and the hierarchy that orders the shapes in them.
pub(super) struct SceneBuffers {
    bvh: Bvh,
    /// In binding order.
    all: [wgpu::Buffer; 5],
}

#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuPrimitive {
    at: Vec3,
    kind: u32,
    edge1: Vec3,
    material: u32,
    edge2: Vec3,
    padding: u32,
    moved: Vec3,
    more_padding: u32,
    normals: [[f32; 4]; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuMaterial {
    color: Vec3,
    kind: u32,
    second_color: Vec3,
    cell: f32,
    alpha: f32,
    ior: f32,
    padding: [u32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuWorld {
    horizon: Vec3,
    lights: u32,
    zenith: Vec3,
    sun_cosine: f32,
    sun_direction: Vec3,
    padding: f32,
    sun_radiance: Vec3,
    more_padding: f32,
}

/// Marks the sun among the lights.
const SUN: u32 = u32::MAX;

/// A cosine larger than any direction's, for a sky without a sun.
const NO_SUN: f32 = 2.0;

/// The shader divides by powers of the roughness; smaller values would overflow 32-bit floats.
const LEAST_ROUGHNESS: f32 = 0.05;

impl SceneBuffers {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene, method: Method) -> Self {
        let bounds = bounds(scene);
        let bvh = if method.hierarchy { Bvh::build(&bounds) } else { Bvh::flat(&bounds) };
        let materials: Vec<_> = scene.materials.iter().map(GpuMaterial::from).collect();
        let mut lights = lights(scene, &bvh.order);
        let world = world(&scene.sky, if method.sample_lights { lights.len() as u32 } else { 0 });
        // Bindings must not be empty.
        lights.push(SUN);
        let storage = wgpu::BufferUsages::STORAGE;
        let moving = storage | wgpu::BufferUsages::COPY_DST;
        let all = [
            buffer(device, &bvh.nodes, moving),
            buffer(device, &primitives(&bvh, scene, scene), moving),
            buffer(device, &[world], wgpu::BufferUsages::UNIFORM),
            buffer(device, &materials, storage),
            buffer(device, &lights, storage),
        ];
        Self { bvh, all }
    }

    /// Moves the shapes from their places in `last` to those in `scene`.
    pub(super) fn update(&mut self, queue: &wgpu::Queue, scene: &Scene, last: &Scene) {
        self.bvh.refit(&bounds(scene));
        let primitives = primitives(&self.bvh, scene, last);
        queue.write_buffer(&self.all[0], 0, bytemuck::cast_slice(&self.bvh.nodes));
        queue.write_buffer(&self.all[1], 0, bytemuck::cast_slice(&primitives));
    }

    /// The number of shapes.
    pub(super) fn shapes(&self) -> usize {
        self.bvh.order.len()
    }

    /// All buffers in binding order, the shapes' first.
    pub(super) fn all(&self) -> Vec<&wgpu::Buffer> {
        self.all.iter().collect()
    }

    /// The buffers for intersecting rays, in binding order.
    pub(super) fn shapes_alone(&self) -> Vec<&wgpu::Buffer> {
        self.all[..2].iter().collect()
    }
}

fn bounds(scene: &Scene) -> Vec<Bounds> {
    scene.shapes.iter().map(|(shape, _)| Bounds::of(shape)).collect()
}

/// The shapes in the hierarchy's order, with their motion since the last frame.
fn primitives(bvh: &Bvh, scene: &Scene, last: &Scene) -> Vec<GpuPrimitive> {
    let primitive = |&shape: &usize| {
        let moved = scene.shapes[shape].0.moved_from(&last.shapes[shape].0);
        GpuPrimitive { moved, ..GpuPrimitive::from(&scene.shapes[shape]) }
    };
    bvh.order.iter().map(primitive).collect()
}

fn buffer<T: NoUninit>(
    device: &wgpu::Device,
    contents: &[T],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("scene"),
        contents: bytemuck::cast_slice(contents),
        usage,
    })
}

/// Positions of the emitting shapes in the hierarchy's order, then the sun. The list itself follows
/// the scene's order, so that a random number picks the same light with any hierarchy.
fn lights(scene: &Scene, order: &[usize]) -> Vec<u32> {
    let shines =
        |shape: usize| matches!(scene.materials[scene.shapes[shape].1], Material::Emitter(_));
    let places = (0..).zip(order).map(|(place, &shape)| (shape, place));
    let mut shining: Vec<_> = places.filter(|(shape, _)| shines(*shape)).collect();
    shining.sort_unstable();
    shining.into_iter().map(|(_, place)| place).chain(scene.sky.sun.map(|_| SUN)).collect()
}

fn world(sky: &Sky, lights: u32) -> GpuWorld {
    let world = GpuWorld { horizon: sky.horizon, zenith: sky.zenith, lights, ..Default::default() };
    let Some(sun) = sky.sun else { return GpuWorld { sun_cosine: NO_SUN, ..world } };
    GpuWorld {
        sun_cosine: (sun.angle.to_radians() / 2.0).cos(),
        sun_direction: sun.direction.normalize(),
        sun_radiance: sun.radiance,
        ..world
    }
}

impl From<&(Shape, usize)> for GpuPrimitive {
    fn from(&(shape, material): &(Shape, usize)) -> Self {
        let primitive = Self { material: material as u32, ..Default::default() };
        match shape {
            Shape::Sphere { center, radius } => {
                Self { at: center, kind: 0, edge1: Vec3::X * radius, ..primitive }
            }
            Shape::Quad { corner, edges: [edge1, edge2] } => {
                Self { at: corner, kind: 1, edge1, edge2, ..primitive }
            }
            Shape::Triangle { corners: [a, b, c], normals } => {
                let normals = normals.map(|n| n.extend(0.0).to_array());
                Self { at: a, kind: 2, edge1: b - a, edge2: c - a, normals, ..primitive }
            }
        }
    }
}

impl From<&Material> for GpuMaterial {
    fn from(material: &Material) -> Self {
        let none = Self::default();
        match *material {
            Material::Diffuse(color) => Self { color, kind: 0, ..none },
            Material::Checker { colors: [color, second_color], cell } => {
                Self { color, second_color, cell, kind: 0, ..none }
            }
            Material::Metal { color, roughness } => {
                let alpha = roughness.max(LEAST_ROUGHNESS).powi(2);
                Self { color, kind: 1, alpha, ..none }
            }
            Material::Glass { color, ior } => Self { color, kind: 2, ior, ..none },
            Material::Emitter(color) => Self { color, kind: 3, ..none },
        }
    }
}
