//! Averages a denoised frame with the last ones along motion vectors. `shaders/accumulate.wgsl`
//! defines it.
//!
//! All state is on the GPU: the call reads the last frame's history and writes this frame's, which
//! a copy then moves into its place. Frames therefore follow each other in submission order.

use super::image::{ImageBinding, ImageFormat, accumulate_features};
use super::input_process::{TILE, scale_binding, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::shader::ShaderRoot;

/// The maximum number of past frames that count in a new pass.
pub const LONGEST: f32 = 8.0;

/// The kernel for motion, albedo, normal and depth in these formats and a result in `output`.
#[must_use]
pub fn spec(sources: [ImageFormat; 4], output: ImageFormat) -> KernelSpec {
    let names = sources.map(ImageFormat::source_name).join(" ");
    let [motion, albedo, normal, depth] = sources.map(ImageFormat::source_binding);
    KernelSpec {
        name: format!("accumulate {names} {}", output.target_name()).into(),
        source: ShaderRoot::Module("accumulate"),
        features: accumulate_features(sources, output).into(),
        entry: "main",
        bindings: vec![
            TILE,
            motion,
            output.target_binding(),
            normal,
            Binding::Buffer,
            albedo,
            depth,
            Binding::Image,
            Binding::Buffer,
            Binding::BufferMut,
            Binding::Uniform { bytes: size_of::<Settings>() as u64, dynamic: false },
        ]
        .into(),
        overrides: &["has_albedo", "has_depth", "has_layers", "has_normal", "unorm_normal"],
        workgroup: [8, 8, 1],
    }
}

/// The uniform of `accumulate.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Settings {
    /// The maximum number of past frames that count.
    pub longest: f32,
    /// 1 if the next frame ignores the history, else 0.
    pub starts_anew: u32,
}

/// The features that tell surfaces apart, besides their light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features {
    /// Whether there is albedo.
    pub albedo: bool,
    /// Whether there are normals.
    pub normal: bool,
    /// Whether there is depth.
    pub depth: bool,
}

impl Features {
    /// Bytes of history per pixel: color and count, and a word for each feature.
    #[must_use]
    pub fn bytes(self) -> u64 {
        16 + 4 * [self.albedo, self.normal, self.depth].into_iter().map(u64::from).sum::<u64>()
    }
}

/// Bytes per pixel that this frame takes in addition to its history if there are further layers.
pub const SOFTNESS_BYTES: u64 = 4;

/// The history of the last frames, and the one that the next frame leaves.
#[derive(Debug)]
pub struct History {
    last: wgpu::Buffer,
    /// With layers, longer than `last` by the softness, which they need from this frame only.
    next: wgpu::Buffer,
    settings: wgpu::Buffer,
    features: Features,
}

impl History {
    /// An empty history for images of `pixels` pixels with these features, with or without further
    /// layers.
    #[must_use]
    pub fn new(device: &wgpu::Device, pixels: u64, features: Features, has_layers: bool) -> Self {
        use wgpu::BufferUsages as Usage;
        let softness = if has_layers { SOFTNESS_BYTES } else { 0 };
        let settings = Settings { longest: LONGEST, starts_anew: 0 };
        Self {
            last: last_frames(device, pixels * features.bytes()),
            next: this_frame(device, pixels * (features.bytes() + softness)),
            features,
            settings: super::packing::filled_buffer(
                device,
                "history",
                bytemuck::bytes_of(&settings),
                Usage::UNIFORM | Usage::COPY_DST,
            ),
        }
    }

    /// This frame's history, which its layers read.
    pub(super) fn of_this_frame(&self) -> &wgpu::Buffer {
        &self.next
    }

    fn has_layers(&self) -> bool {
        self.next.size() > self.last.size()
    }

    /// Records the copy that makes this frame the last one. Comes after the [`accumulate`] call and
    /// those of the layers.
    pub fn advance(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.next, 0, &self.last, 0, self.last.size());
        if self.has_layers() {
            encoder.clear_buffer(&self.next, self.last.size(), None);
        }
        encoder.clear_buffer(&self.settings, ANEW, Some(size_of::<u32>() as u64));
    }

    /// Sets the maximum number of past frames that count in later submissions.
    pub fn set_longest(&self, queue: &wgpu::Queue, frames: f32) {
        queue.write_buffer(&self.settings, 0, bytemuck::bytes_of(&frames));
    }

    /// Makes the next submitted frame ignore the history.
    pub fn reset(&self, queue: &wgpu::Queue) {
        queue.write_buffer(&self.settings, ANEW, bytemuck::bytes_of(&1_u32));
    }
}

/// A buffer for the history of the last frames.
pub(super) fn last_frames(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    buffer(device, "last frames", size, wgpu::BufferUsages::COPY_DST)
}

/// A buffer for the history that this frame leaves.
pub(super) fn this_frame(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    buffer(device, "this frame", size, usage)
}

fn buffer(
    device: &wgpu::Device,
    label: &str,
    size: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: usage | wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}

/// Byte offset of [`Settings::starts_anew`].
const ANEW: u64 = std::mem::offset_of!(Settings, starts_anew) as u64;

/// The images of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameImages<'a> {
    /// A [`Tile`](super::tile::Tile) with the size and layouts of the images.
    pub tile: &'a wgpu::Buffer,
    /// The denoised frame, `rgba32float`.
    pub denoised: &'a wgpu::TextureView,
    /// Where each pixel's surface was in the last frame, relative to the pixel, in pixels.
    pub motion: ImageBinding<'a>,
    /// Albedo in `[0, 1]`.
    pub albedo: Option<ImageBinding<'a>>,
    /// Normal, stored according to `unorm_normal`.
    pub normal: Option<ImageBinding<'a>>,
    /// Whether normals are stored as `0.5 n + 0.5`, with 0 where no surface was hit.
    pub unorm_normal: bool,
    /// Distance from the camera's plane.
    pub depth: Option<ImageBinding<'a>>,
    /// One 32-bit float: the factor that brings color to the network's exposure.
    pub input_scale: &'a wgpu::Buffer,
    /// Receives the mean, with the denoised frame's alpha.
    pub output: ImageBinding<'a>,
}

impl<'a> FrameImages<'a> {
    /// The images to bind as motion, albedo, normal and depth. An absent image is never read, but
    /// its binding cannot stay empty.
    fn sources(&self) -> [ImageBinding<'a>; 4] {
        let or_motion = |image: Option<_>| image.unwrap_or(self.motion);
        [self.motion, or_motion(self.albedo), or_motion(self.normal), or_motion(self.depth)]
    }

    fn constants(&self, history: &History) -> [(&'static str, f64); 5] {
        let Features { albedo, normal, depth } = history.features;
        let flag = |name, value| (name, f64::from(u8::from(value)));
        [
            flag("has_albedo", albedo),
            flag("has_depth", depth),
            flag("has_layers", history.has_layers()),
            flag("has_normal", normal),
            flag("unorm_normal", self.unorm_normal),
        ]
    }
}

/// The call for an image of `size` pixels. Record it with [`Dispatch::record_at`] and the offset of
/// the tile, then [`History::advance`]. `images` must have the history's features. Further layers
/// have [calls of their own](super::accumulate_layer) around this one.
#[must_use]
pub fn accumulate(
    context: &Context,
    size: [u32; 2],
    images: &FrameImages<'_>,
    history: &History,
) -> Dispatch {
    let sources = images.sources();
    let spec = spec(sources.map(|image| image.format()), images.output.format());
    let kernel = context.kernel(&spec, &images.constants(history));
    let [motion, albedo, normal, depth] = sources.map(|image| image.resource());
    let resources = [
        tile_binding(images.tile),
        motion,
        images.output.resource(),
        normal,
        scale_binding(images.input_scale),
        albedo,
        depth,
        wgpu::BindingResource::TextureView(images.denoised),
        history.last.as_entire_binding(),
        history.next.as_entire_binding(),
        history.settings.as_entire_binding(),
    ];
    kernel.dispatch(kernel.bind(&context.device, &resources), [size[0], size[1], 1])
}
