//! Shows linear images on the screen.

use bytemuck::{Pod, Zeroable};

/// The pipeline of `present.wgsl`.
pub(super) struct Present {
    pipeline: wgpu::RenderPipeline,
    screen: wgpu::Buffer,
    encode: bool,
}

/// Uniforms, laid out as in `present.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GpuScreen {
    divider: f32,
    exposure: f32,
    encode: u32,
    divided: u32,
}

/// How the noisy and the denoised image share the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    /// The noisy image is shown left of this column.
    pub(super) divider: f32,
    /// Whether a line marks the divider.
    pub(super) marked: bool,
}

/// Factor on color before the tone curve, which darkens mid-tones.
const EXPOSURE: f32 = 0.8;

impl Present {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("present.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("present"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("present"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, screen: screen_buffer(device), encode: !format.is_srgb() }
    }

    /// Binds the two images, which must have the screen's size.
    pub(super) fn bind(
        &self,
        device: &wgpu::Device,
        noisy: &wgpu::Texture,
        denoised: &wgpu::Texture,
    ) -> wgpu::BindGroup {
        let [noisy, denoised] = [noisy, denoised].map(|t| t.create_view(&Default::default()));
        let resources = [
            self.screen.as_entire_binding(),
            wgpu::BindingResource::TextureView(&noisy),
            wgpu::BindingResource::TextureView(&denoised),
        ];
        let entries = (0..).zip(resources);
        let entries = entries.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries.collect::<Vec<_>>(),
        })
    }

    pub(super) fn write_split(&self, queue: &wgpu::Queue, split: Split) {
        let screen = GpuScreen {
            divider: split.divider,
            exposure: EXPOSURE,
            encode: self.encode.into(),
            divided: split.marked.into(),
        };
        queue.write_buffer(&self.screen, 0, bytemuck::bytes_of(&screen));
    }

    /// Records drawing of the bound images to the surface.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        images: &wgpu::BindGroup,
        target: &wgpu::TextureView,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let attachment = wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(attachment)],
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, images, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn screen_buffer(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("screen"),
        size: size_of::<GpuScreen>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
