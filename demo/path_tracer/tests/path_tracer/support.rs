//! Draws scenes on this machine's adapter, and estimates means.

use std::sync::OnceLock;

use glam::{Vec3, vec3};
use wgdenoise::Gpu;

use path_tracer::renderer::camera::Camera;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scene::{Scene, Shape};
use path_tracer::renderer::{Kernels, Method, Renderer};

/// The images of a film.
pub(crate) struct Drawn {
    pub(crate) color: Vec<[f32; 4]>,
    pub(crate) albedo: Vec<[f32; 4]>,
    pub(crate) normal: Vec<[f32; 4]>,
}

/// Size, samples per pixel and seed.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) seed: u32,
}

/// The device shared by all tests, without features and with WebGPU's default limits.
pub(crate) struct Bench {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) kernels: Kernels,
}

pub(crate) fn bench() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let adapter = Gpu::open(None).expect("the tests need an adapter").adapter;
        let device = adapter.request_device(&wgpu::DeviceDescriptor::default());
        let opened = pollster::block_on(device);
        let (device, queue) = opened.expect("every adapter has what WebGPU needs");
        let kernels = Kernels::new(&device);
        Bench { device, queue, kernels }
    })
}

/// Draws a scene and reads its images.
pub(crate) fn draw(scene: &Scene, method: Method, shot: Shot) -> Drawn {
    let Bench { device, queue, kernels } = bench();
    expose(&Renderer::new(device, queue, kernels, scene, method), scene, shot)
}

/// Draws with a renderer created for an earlier state of the scene.
pub(crate) fn draw_moved(before: &Scene, after: &Scene, shot: Shot) -> Drawn {
    let Bench { device, queue, kernels } = bench();
    let mut renderer = Renderer::new(device, queue, kernels, before, Method::default());
    renderer.update(after, before).expect("both have the same shapes");
    expose(&renderer, after, shot)
}

fn expose(renderer: &Renderer, scene: &Scene, shot: Shot) -> Drawn {
    let Bench { device, queue, .. } = bench();
    let mut film = renderer.film(shot.size, shot.seed).expect("a small film");
    while film.samples < shot.samples {
        let mut encoder = device.create_command_encoder(&Default::default());
        let more = shot.samples - film.samples;
        renderer.encode(&mut encoder, &mut film, &scene.camera, more, None);
        queue.submit([encoder.finish()]);
    }
    let read = |texture| read(device, queue, texture).expect("the film can be read");
    Drawn { color: read(&film.color), albedo: read(&film.albedo), normal: read(&film.normal) }
}

/// A camera that looks at the origin.
pub(crate) fn camera_at(position: Vec3, field_of_view: f32) -> Camera {
    Camera { position, target: Vec3::ZERO, field_of_view }
}

pub(crate) fn sphere(center: Vec3, radius: f32) -> Shape {
    Shape::Sphere { center, radius }
}

/// A square at height 0 that faces up.
pub(crate) fn floor(reach: f32) -> Shape {
    let edges = [Vec3::Z * 2.0 * reach, Vec3::X * 2.0 * reach];
    Shape::Quad { corner: vec3(-reach, 0.0, -reach), edges }
}

/// The mean absolute difference after x ↦ x / (1 + x), which keeps bright pixels from dominating.
pub(crate) fn error(found: &[[f32; 4]], reference: &[[f32; 4]]) -> f64 {
    assert_eq!(found.len(), reference.len());
    let shown = |v: f32| f64::from(v / (1.0 + v));
    let of_pixel = |(a, b): (&[f32; 4], &[f32; 4])| -> f64 {
        (0..3).map(|c| (shown(a[c]) - shown(b[c])).abs()).sum()
    };
    found.iter().zip(reference).map(of_pixel).sum::<f64>() / (3 * found.len()) as f64
}

/// The red channel.
pub(crate) fn reds(color: &[[f32; 4]]) -> Vec<f64> {
    color.iter().map(|pixel| f64::from(pixel[0])).collect()
}

/// The mean of independent numbers and its standard error.
pub(crate) fn estimate(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Fails if the mean is off by more than five standard errors, a one-in-a-million chance, or if the
/// standard error exceeds the share `precision` of `expected`.
pub(crate) fn assert_mean(what: &str, values: &[f64], expected: f64, precision: f64) {
    let (mean, error) = estimate(values);
    assert!(error < precision * expected, "{what}: {mean} ± {error} is too uncertain");
    // Values that are exact up to rounding have no spread.
    let rounding = 1e-5 * expected;
    let off = (mean - expected).abs();
    assert!(off < 5.0 * error + rounding, "{what}: {mean} ± {error}, expected {expected}");
}
