//! A progressive path tracer: a scene on the GPU, drawn onto a film sample by sample.
//!
//! It asks for no feature and no more than WebGPU's default limits, and knows nothing of the
//! denoiser: its film is textures, as any renderer's would be.

pub(crate) mod bvh;
pub(crate) mod camera;
pub(crate) mod exr;
pub(crate) mod film;
pub(crate) mod meshes;
pub(crate) mod pixels;
pub(crate) mod scene;
mod scene_buffers;
pub(crate) mod scenes;

use self::camera::Camera;
use self::film::Film;
use self::scene::Scene;
use self::scene_buffers::SceneBuffers;

/// Every error is one sentence for a person to act on.
pub(crate) type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Most samples per pixel of one dispatch, so that slow adapters answer before a watchdog bites.
pub(crate) const SAMPLES_PER_DISPATCH: u32 = 4;

/// How light is computed. What is not the default is slower and for tests to compare with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Method {
    /// Aim at lights, rather than wait until a path meets one.
    pub(crate) sample_lights: bool,
    /// Walk a tree of boxes, rather than test every shape.
    pub(crate) hierarchy: bool,
}

/// What draws, compiled once for all scenes.
#[derive(Clone)]
pub(crate) struct Kernels {
    path_trace: wgpu::ComputePipeline,
    resolve: wgpu::ComputePipeline,
}

/// A scene and the kernels that draw it.
pub(crate) struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Kernels,
    scene: wgpu::BindGroup,
}

pub(crate) const PATH_TRACE: &str = concat!(
    include_str!("shaders/frame.wgsl"),
    include_str!("shaders/scene.wgsl"),
    include_str!("shaders/random.wgsl"),
    include_str!("shaders/intersect.wgsl"),
    include_str!("shaders/surface.wgsl"),
    include_str!("shaders/bsdf.wgsl"),
    include_str!("shaders/lights.wgsl"),
    include_str!("shaders/path_trace.wgsl"),
);

pub(crate) const RESOLVE: &str =
    concat!(include_str!("shaders/frame.wgsl"), include_str!("shaders/resolve.wgsl"));

/// Pixels per side of a workgroup.
const WORKGROUP: u32 = 8;

impl Default for Method {
    fn default() -> Self {
        Self { sample_lights: true, hierarchy: true }
    }
}

impl Kernels {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Self {
            path_trace: pipeline(device, "path_trace", PATH_TRACE),
            resolve: pipeline(device, "resolve", RESOLVE),
        }
    }
}

impl Renderer {
    /// Uploads the scene, which has at least one shape.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        scene: &Scene,
        method: Method,
    ) -> Self {
        let buffers = SceneBuffers::new(device, scene, method);
        let scene = bind(device, &kernels.path_trace, 0, &buffers.all(), &[]);
        Self { device: device.clone(), queue: queue.clone(), kernels: kernels.clone(), scene }
    }

    /// Records up to [`SAMPLES_PER_DISPATCH`] more samples per pixel and their means. To be
    /// submitted before the next call, since what the kernels are told is written to one buffer.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        film: &mut Film,
        camera: &Camera,
        samples: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let samples = samples.min(SAMPLES_PER_DISPATCH);
        film.write_frame(&self.queue, camera, samples);
        film.samples += samples;
        let [x, y] = film.size.map(|side| side.div_ceil(WORKGROUP));
        let label = Some("path tracer");
        let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.kernels.path_trace);
        pass.set_bind_group(0, &self.scene, &[]);
        pass.set_bind_group(1, &film.path_trace, &[]);
        pass.dispatch_workgroups(x, y, 1);
        pass.set_pipeline(&self.kernels.resolve);
        pass.set_bind_group(0, &film.resolve, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}

/// The kernel of this name, bound as its shader says.
fn pipeline(device: &wgpu::Device, entry: &str, source: &str) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module: &module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// A group of buffers and then textures, from binding 0 on.
fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    group: u32,
    buffers: &[&wgpu::Buffer],
    textures: &[&wgpu::Texture],
) -> wgpu::BindGroup {
    let views: Vec<_> = textures.iter().map(|t| t.create_view(&Default::default())).collect();
    let buffers = buffers.iter().map(|buffer| buffer.as_entire_binding());
    let resources = buffers.chain(views.iter().map(wgpu::BindingResource::TextureView));
    let entries = (0..).zip(resources);
    let entries = entries.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(group),
        entries: &entries.collect::<Vec<_>>(),
    })
}
