//! Motion vectors and depth, for filters that reuse the last frame.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::camera::Camera;
use super::film::{check, texture, uniform_buffer};
use super::{Renderer, Result, WORKGROUP, bind};

/// Images of the motion since the last frame, at the pixels' centers. For mirrors and glass they
/// show the surface, not what is seen in it.
pub struct Motion {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The surface's position in the last frame relative to the pixel, in pixels: x to the right, y
    /// down; `rg32float`. Points outside the image if the surface was behind the camera.
    pub vectors: wgpu::Texture,
    /// Distance of the surface from the camera's plane in meters, 0 for the background; `r32float`.
    pub depth: wgpu::Texture,
    views: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

/// A camera, laid out as `View` in `shaders/motion.wgsl`, where vectors of three are padded.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuView {
    origin: Vec4,
    right: Vec4,
    up: Vec4,
    forward: Vec4,
}

/// Uniforms of one dispatch, laid out as `Views` in `shaders/motion.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct GpuViews {
    now: GpuView,
    last: GpuView,
    size: [u32; 2],
    padding: [u32; 2],
}

impl Renderer {
    /// Empty images of this size.
    ///
    /// # Errors
    /// If the device cannot hold images of this size.
    pub fn motion(&self, size: [u32; 2]) -> Result<Motion> {
        let device = &self.device;
        check(&device.limits(), size)?;
        let views = uniform_buffer::<GpuViews>(device, "views");
        let vectors = texture(device, "motion", size, wgpu::TextureFormat::Rg32Float);
        let depth = texture(device, "depth", size, wgpu::TextureFormat::R32Float);
        let bindings = bind(device, &self.kernels.motion, 1, &[&views], &[&vectors, &depth]);
        Ok(Motion { size, vectors, depth, views, bindings })
    }

    /// Records motion vectors and depth of the scene as [`update`](Self::update) left it, seen by
    /// this frame's camera and the last frame's. Submit before the next call, which overwrites this
    /// one's uniforms.
    pub fn encode_motion(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        motion: &Motion,
        [now, last]: [&Camera; 2],
    ) {
        let [now, last] = [now, last].map(|camera| GpuView::new(camera, motion.size));
        let views = GpuViews { now, last, size: motion.size, ..Default::default() };
        self.queue.write_buffer(&motion.views, 0, bytemuck::bytes_of(&views));
        let [x, y] = motion.size.map(|side| side.div_ceil(WORKGROUP));
        let label = Some("motion");
        let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.kernels.motion);
        pass.set_bind_group(0, &self.shapes, &[]);
        pass.set_bind_group(1, &motion.bindings, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}

impl GpuView {
    fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let plane = camera.image_plane(size);
        let [origin, right, up, forward] =
            [camera.position, plane.right, plane.up, plane.forward].map(|v| v.extend(0.0));
        Self { origin, right, up, forward }
    }
}
