//! A progressive path tracer: adds samples of a scene to a film, on the GPU.
//!
//! It runs on any WebGPU device with default limits and is independent of the denoiser: its film
//! consists of textures, like any renderer's.

pub mod bvh;
pub mod camera;
pub mod film;
pub mod meshes;
pub mod motion;
pub mod pixels;
pub mod scene;
mod scene_buffers;
pub mod scenes;

use self::camera::Camera;
use self::film::Film;
use self::scene::Scene;
use self::scene_buffers::SceneBuffers;

/// The result of a fallible operation; the error is one sentence for the user.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Maximum samples per pixel in one dispatch: on slow adapters, a watchdog ends longer ones.
pub const SAMPLES_PER_DISPATCH: u32 = 4;

/// How light is found. Tests compare the default with the slower alternatives.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Sample the lights directly, besides finding them by chance.
    pub sample_lights: bool,
    /// Traverse a bounding volume hierarchy instead of testing every shape.
    pub hierarchy: bool,
}

/// The compute pipelines, shared by all scenes.
#[derive(Clone)]
pub struct Kernels {
    path_trace: wgpu::ComputePipeline,
    resolve: wgpu::ComputePipeline,
    motion: wgpu::ComputePipeline,
}

/// A scene on the GPU and the kernels that draw it.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Kernels,
    buffers: SceneBuffers,
    scene: wgpu::BindGroup,
    /// Only the scene's shapes, for motion vectors.
    shapes: wgpu::BindGroup,
}

/// The kernel that adds samples to a film.
pub const PATH_TRACE: &str = concat!(
    include_str!("shaders/frame.wgsl"),
    include_str!("shaders/scene.wgsl"),
    include_str!("shaders/random.wgsl"),
    include_str!("shaders/intersect.wgsl"),
    include_str!("shaders/surface.wgsl"),
    include_str!("shaders/bsdf.wgsl"),
    include_str!("shaders/lights.wgsl"),
    include_str!("shaders/path_trace.wgsl"),
);

/// The kernel that averages a film's samples into its textures.
pub const RESOLVE: &str =
    concat!(include_str!("shaders/frame.wgsl"), include_str!("shaders/resolve.wgsl"));

/// The kernel that computes motion vectors and depth.
pub const MOTION: &str = concat!(
    include_str!("shaders/scene.wgsl"),
    include_str!("shaders/intersect.wgsl"),
    include_str!("shaders/motion.wgsl"),
);

/// Pixels per side of a workgroup.
const WORKGROUP: u32 = 8;

impl Default for Method {
    fn default() -> Self {
        Self { sample_lights: true, hierarchy: true }
    }
}

impl Kernels {
    /// Compiles the kernels.
    #[must_use]
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            path_trace: pipeline(device, "path_trace", PATH_TRACE),
            resolve: pipeline(device, "resolve", RESOLVE),
            motion: pipeline(device, "motion", MOTION),
        }
    }
}

impl Renderer {
    /// Uploads a scene of at least one shape.
    #[must_use]
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        scene: &Scene,
        method: Method,
    ) -> Self {
        let buffers = SceneBuffers::new(device, scene, method);
        let scene = bind(device, &kernels.path_trace, 0, &buffers.all(), &[]);
        let shapes = bind(device, &kernels.motion, 0, &buffers.shapes_alone(), &[]);
        let (device, queue, kernels) = (device.clone(), queue.clone(), kernels.clone());
        Self { device, queue, kernels, buffers, scene, shapes }
    }

    /// Moves the shapes to their places in `scene`; `last` has their places in the last frame.
    /// Shapes may move but not rotate or change otherwise; materials and sky stay.
    ///
    /// # Errors
    /// If either scene's number of shapes differs from the renderer's.
    pub fn update(&mut self, scene: &Scene, last: &Scene) -> Result<()> {
        let shapes = self.buffers.shapes();
        if let Some(other) =
            [scene, last].map(|s| s.shapes.len()).into_iter().find(|&n| n != shapes)
        {
            return Err(format!(
                "a scene of {other} shapes cannot replace one of {shapes}: make another renderer for it"
            )
            .into());
        }
        self.buffers.update(&self.queue, scene, last);
        Ok(())
    }

    /// Records up to [`SAMPLES_PER_DISPATCH`] more samples per pixel, then averages all. Submit
    /// before the next call, which overwrites this one's uniforms.
    pub fn encode(
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

/// The pipeline for the entry point `entry`; its bindings follow from the shader.
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

/// Binds the buffers from binding 0 on, then the textures.
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
