//! Draws images into the window. Exposure, tone curve, zoom, split and difference are uniforms of
//! one small shader, so changing them costs only a frame.

use std::num::NonZeroU64;

use eframe::egui::PaintCallbackInfo;
use eframe::egui_wgpu::{CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use wgdenoise::wgpu;

use crate::gpu::texture::Texture;
use crate::state::looking::Shown;

/// How to interpret an image's values; the numbers match the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Light = 0,
    Surface = 1,
    Direction = 2,
    Difference = 3,
}

impl Kind {
    /// The kind of an image. With `has_map`, a difference is a color map of errors.
    pub(crate) fn of(shown: Shown, has_map: bool) -> Self {
        match shown {
            Shown::Noisy | Shown::Denoised | Shown::Reference => Self::Light,
            Shown::Albedo => Self::Surface,
            Shown::Normal => Self::Direction,
            Shown::Difference if has_map => Self::Surface,
            Shown::Difference => Self::Difference,
        }
    }
}

/// The uniforms of `screen.wgsl`, documented there.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct View {
    pub(crate) area: [f32; 2],
    pub(crate) center: [f32; 2],
    pub(crate) size: [f32; 2],
    pub(crate) kinds: [u32; 2],
    pub(crate) zoom: f32,
    pub(crate) gain: f32,
    pub(crate) amplification: f32,
    pub(crate) split: f32,
    pub(crate) curve: u32,
    pub(crate) halves: u32,
    pub(crate) encodes: u32,
    pub(crate) padding: u32,
}

/// What one frame draws.
pub(crate) struct Draw {
    pub(crate) view: View,
    /// The left image, the right image, and the one that a difference subtracts.
    pub(crate) images: [Texture; 3],
}

/// The pipeline, which the window's renderer keeps.
struct Screen {
    pipeline: wgpu::RenderPipeline,
    uniforms: wgpu::Buffer,
    encodes: bool,
}

/// The bind group for [`CallbackTrait::paint`].
struct Bound(wgpu::BindGroup);

/// Compiles the shader. Call it once, before anything is drawn.
pub(crate) fn install(state: &RenderState) {
    let device = &state.device;
    let module = device.create_shader_module(wgpu::include_wgsl!("screen.wgsl"));
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("screen"),
        layout: Some(&layout(device)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(state.target_format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("view"),
        size: size_of::<View>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let screen = Screen { pipeline, uniforms, encodes: state.target_format.is_srgb() };
    state.renderer.write().callback_resources.insert(screen);
}

fn layout(device: &wgpu::Device) -> wgpu::PipelineLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: NonZeroU64::new(size_of::<View>() as u64),
    };
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("screen"),
        entries: &[entry(0, uniform), entry(1, image), entry(2, image), entry(3, image)],
    });
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("screen"),
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    })
}

impl Screen {
    fn bind(&self, device: &wgpu::Device, images: &[Texture; 3]) -> wgpu::BindGroup {
        let image = |i: usize| wgpu::BindingResource::TextureView(images[i].view());
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("screen"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                entry(0, self.uniforms.as_entire_binding()),
                entry(1, image(0)),
                entry(2, image(1)),
                entry(3, image(2)),
            ],
        })
    }
}

impl CallbackTrait for Draw {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(screen) = resources.get::<Screen>() {
            let view = View { encodes: screen.encodes.into(), ..self.view };
            queue.write_buffer(&screen.uniforms, 0, bytemuck::bytes_of(&view));
            let bound = Bound(screen.bind(device, &self.images));
            resources.insert(bound);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        if let (Some(screen), Some(Bound(group))) =
            (resources.get::<Screen>(), resources.get::<Bound>())
        {
            pass.set_pipeline(&screen.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}
