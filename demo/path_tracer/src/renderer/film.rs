//! What a scene is drawn onto: sums of samples, and textures with their means.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::camera::Camera;
use super::{Renderer, Result, bind};

/// The images of one size.
pub(crate) struct Film {
    /// Pixels per row, and rows.
    pub(crate) size: [u32; 2],
    /// Samples per pixel that the images hold; 0 begins anew.
    pub(crate) samples: u32,
    /// Another seed is other noise.
    pub(crate) seed: u32,
    /// Linear colour, `rgba32float`; alpha is the share of the pixel that surfaces cover.
    pub(crate) color: wgpu::Texture,
    /// Reflectance of what is seen first, `rgba8unorm`.
    pub(crate) albedo: wgpu::Texture,
    /// Normal of what is seen first, in world space, `rgba16float`.
    pub(crate) normal: wgpu::Texture,
    frame: wgpu::Buffer,
    pub(super) path_trace: wgpu::BindGroup,
    pub(super) resolve: wgpu::BindGroup,
}

/// What one dispatch draws, as `shaders/frame.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuFrame {
    origin: Vec3,
    first_sample: u32,
    right: Vec3,
    samples: u32,
    up: Vec3,
    seed: u32,
    forward: Vec3,
    padding: u32,
    size: [u32; 2],
    more_padding: [u32; 2],
}

/// Bytes of a pixel in one of the sums.
const SUM_BYTES: u64 = size_of::<[f32; 4]>() as u64;

impl Renderer {
    /// Images of this size, without a sample yet.
    ///
    /// # Errors
    /// If the device cannot hold images of this size.
    pub(crate) fn film(&self, size: [u32; 2], seed: u32) -> Result<Film> {
        let device = &self.device;
        check(&device.limits(), size)?;
        let frame = frame_buffer(device);
        let sums = ["colors", "albedos", "normals"].map(|label| sum(device, label, size));
        let buffers: Vec<_> = std::iter::once(&frame).chain(&sums).collect();
        let color = texture(device, "color", size, wgpu::TextureFormat::Rgba32Float);
        let albedo = texture(device, "albedo", size, wgpu::TextureFormat::Rgba8Unorm);
        let normal = texture(device, "normal", size, wgpu::TextureFormat::Rgba16Float);
        let path_trace = bind(device, &self.kernels.path_trace, 1, &buffers, &[]);
        let resolve = bind(device, &self.kernels.resolve, 0, &buffers, &[&color, &albedo, &normal]);
        Ok(Film { size, samples: 0, seed, color, albedo, normal, frame, path_trace, resolve })
    }
}

impl Film {
    /// Says what the next dispatch draws: so many more samples.
    pub(super) fn write_frame(&self, queue: &wgpu::Queue, camera: &Camera, samples: u32) {
        let plane = camera.image_plane(self.size);
        let frame = GpuFrame {
            origin: camera.position,
            first_sample: self.samples,
            right: plane.right,
            samples,
            up: plane.up,
            seed: self.seed,
            forward: plane.forward,
            size: self.size,
            ..Default::default()
        };
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
    }
}

/// A texture for one kernel to write and others to read.
pub(crate) fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn sum(device: &wgpu::Device, label: &str, [width, height]: [u32; 2]) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: u64::from(width) * u64::from(height) * SUM_BYTES,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}

fn frame_buffer(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("frame"),
        size: size_of::<GpuFrame>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn check(limits: &wgpu::Limits, [width, height]: [u32; 2]) -> Result<()> {
    let side = limits.max_texture_dimension_2d;
    let pixels = limits.max_storage_buffer_binding_size / SUM_BYTES;
    let fits = (1..=side).contains(&width)
        && (1..=side).contains(&height)
        && u64::from(width) * u64::from(height) <= pixels;
    let problem = || {
        format!("{width}×{height}: the device takes 1 to {side} pixels a side and {pixels} in all")
    };
    if fits { Ok(()) } else { Err(problem().into()) }
}
