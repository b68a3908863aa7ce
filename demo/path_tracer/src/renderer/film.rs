//! The film: sums of samples, and textures with their averages.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::camera::Camera;
use super::{Renderer, Result, bind};

/// The images of one picture.
pub struct Film {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel so far.
    pub samples: u32,
    /// Selects the random numbers, and thus the noise.
    pub seed: u32,
    /// Linear color, `rgba32float`; alpha is the pixel's coverage.
    pub color: wgpu::Texture,
    /// Reflectance of the first surface, `rgba8unorm`.
    pub albedo: wgpu::Texture,
    /// World-space normal of the first surface, `rgba16float`.
    pub normal: wgpu::Texture,
    frame: wgpu::Buffer,
    pub(super) path_trace: wgpu::BindGroup,
    pub(super) resolve: wgpu::BindGroup,
}

/// Uniforms of one dispatch, laid out as in `shaders/frame.wgsl`.
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

/// Bytes per pixel of one sum.
const SUM_BYTES: u64 = size_of::<[f32; 4]>() as u64;

impl Renderer {
    /// Creates an empty film of this size.
    ///
    /// # Errors
    /// If the device cannot hold images of this size.
    pub fn film(&self, size: [u32; 2], seed: u32) -> Result<Film> {
        let device = &self.device;
        check(&device.limits(), size)?;
        let frame = uniform_buffer::<GpuFrame>(device, "frame");
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
    /// Begins another picture with new noise: fixed noise would look like a dirty window in front
    /// of a moving scene, and averaging frames would not remove it.
    pub fn start_over(&mut self) {
        self.samples = 0;
        self.seed = self.seed.wrapping_add(1);
    }

    /// Writes the uniforms of the next dispatch, which adds this many samples.
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

/// A texture that one kernel writes and another reads.
#[must_use]
pub fn texture(
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

/// A buffer for uniforms of this type.
pub(super) fn uniform_buffer<T>(device: &wgpu::Device, label: &str) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Rejects sizes that the device cannot hold.
pub(super) fn check(limits: &wgpu::Limits, [width, height]: [u32; 2]) -> Result<()> {
    let side = limits.max_texture_dimension_2d;
    let pixels = limits.max_storage_buffer_binding_size / SUM_BYTES;
    let fits = (1..=side).contains(&width)
        && (1..=side).contains(&height)
        && u64::from(width) * u64::from(height) <= pixels;
    let problem = || {
        format!(
            "{width}×{height} does not fit the device, which takes up to {side} pixels a side and \
             {pixels} in total"
        )
    };
    if fits { Ok(()) } else { Err(problem().into()) }
}
