//! The kernels that fill a texture's mip levels.

use wgdenoise::{FinishedTile, Rect, wgpu};
use wgpu::util::DeviceExt as _;

/// Pixels of an image on the GPU: linear red, green and blue in 32-bit float, packed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixels<'a> {
    pub(crate) buffer: &'a wgpu::Buffer,
    /// Index of the first pixel in the buffer.
    pub(crate) first: u32,
    /// Row stride of the buffer, in pixels.
    pub(crate) stride: u32,
    /// Where the pixels go in the image.
    pub(crate) rect: Rect,
}

impl<'a> From<FinishedTile<'a>> for Pixels<'a> {
    fn from(tile: FinishedTile<'a>) -> Self {
        let FinishedTile { buffer, first, stride, rect, .. } = tile;
        Self { buffer, first, stride, rect }
    }
}

/// The uniforms of `levels.wgsl`, documented there.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Place {
    first: u32,
    stride: u32,
    origin: [u32; 2],
    size: [u32; 2],
}

/// The compiled kernels, with their device.
#[derive(Debug)]
pub(crate) struct Levels {
    device: wgpu::Device,
    queue: wgpu::Queue,
    place: wgpu::ComputePipeline,
    halve: wgpu::ComputePipeline,
}

impl Levels {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("levels.wgsl"));
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Self {
            device: device.clone(),
            queue: queue.clone(),
            place: pipeline("place_pixels"),
            halve: pipeline("halve"),
        }
    }

    /// Submits the copy of pixels to a level.
    pub(crate) fn place(&self, pixels: &Pixels<'_>, level: &wgpu::TextureView) {
        let &Pixels { buffer, first, stride, rect } = pixels;
        let place = Place { first, stride, origin: rect.begin, size: rect.size() };
        let uniform = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("place"),
            contents: bytemuck::bytes_of(&place),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            buffer.as_entire_binding(),
            wgpu::BindingResource::TextureView(level),
        ];
        self.submit(&self.place, &resources, rect.size());
    }

    /// Submits the downsampling of a level to the next one, which has this size.
    pub(crate) fn halve(&self, [from, to]: [&wgpu::TextureView; 2], size: [u32; 2]) {
        let resources = [from, to].map(wgpu::BindingResource::TextureView);
        self.submit(&self.halve, &resources, size);
    }

    /// Submits a kernel with one invocation per pixel.
    fn submit(
        &self,
        pipeline: &wgpu::ComputePipeline,
        resources: &[wgpu::BindingResource<'_>],
        [width, height]: [u32; 2],
    ) {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
    }
}
