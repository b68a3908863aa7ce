//! Removes Monte Carlo noise from path-traced images on any GPU: a U-Net in hand-written WGSL,
//! dispatched through [`wgpu`], with trained weights built in.
//!
//! - A [`Denoiser`] holds compiled kernels and weights on your device and serves images of any
//!   size. [`Denoiser::denoise`] takes images on the CPU and blocks until the result is ready.
//! - A [`Pass`] binds a denoiser to one size and to images on the GPU. [`Pass::encode`] records
//!   into your command encoder; it creates no resources and cannot fail.
//!
//! Color is linear and scene-referred, at any exposure. Albedo (linear, `[0, 1]`) and normal
//! (`[−1, 1]`) are optional and improve the result. Before the network runs, NaN pixels and lone
//! infinite pixels are filled from their neighbors, groups of infinite pixels count as very bright,
//! and isolated fireflies are darkened. The output is finite. It is non-negative unless the noisy
//! color has negative channels that are kept for wide gamuts, the weights denoise directions, or
//! [`Pass::set_blend`] mixes in negative noisy color.
//!
//! # An image on the CPU
//!
//! ```
//! use wgdenoise::{Denoiser, Frame, Gpu, Image, Options, Quality, Weights};
//!
//! let gpu = Gpu::open(None)?;
//! let weights = Weights::builtin(Quality::Fast)?;
//! let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())?;
//!
//! let color = Image::filled(64, 48, [0.5, 0.4, 0.3])?;
//! let albedo = Image::filled(64, 48, [0.8, 0.7, 0.6])?;
//! let clean = denoiser.denoise(&Frame::new(&color).albedo(&albedo))?;
//! assert_eq!(clean.size(), (64, 48));
//! # Ok::<(), wgdenoise::Error>(())
//! ```
//!
//! # A pass inside a renderer
//!
//! ```
//! use wgdenoise::{Denoiser, Gpu, Options, PassDescriptor, PassImage, Quality, Weights};
//! # use wgdenoise::wgpu::{self, TextureFormat as Format, TextureUsages as Usage};
//! # let Gpu { device, queue, .. } = Gpu::open(None)?;
//! # let texture = |format, usage| device.create_texture(&wgpu::TextureDescriptor {
//! #     label: None, size: wgpu::Extent3d { width: 320, height: 200, depth_or_array_layers: 1 },
//! #     mip_level_count: 1, sample_count: 1, dimension: wgpu::TextureDimension::D2, format, usage,
//! #     view_formats: &[] });
//! # let noisy = texture(Format::Rgba32Float, Usage::TEXTURE_BINDING);
//! # let albedo = texture(Format::Rgba8Unorm, Usage::TEXTURE_BINDING);
//! # let normal = texture(Format::Rgba16Float, Usage::TEXTURE_BINDING);
//! # let clean = texture(Format::Rgba16Float, Usage::STORAGE_BINDING | Usage::TEXTURE_BINDING);
//! // Once, on the renderer's own device and queue:
//! let weights = Weights::builtin(Quality::Fast)?;
//! let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default())?;
//! // Once per size; the images may be textures, buffers or a mix:
//! let [noisy, albedo, normal, clean] = [&noisy, &albedo, &normal, &clean].map(PassImage::Texture);
//! let images = PassDescriptor::new(320, 200, noisy, clean).albedo(albedo).normal(normal);
//! let pass = denoiser.pass(&images)?;
//! // Every frame, between the renderer's own passes:
//! let mut encoder = device.create_command_encoder(&Default::default());
//! pass.encode(&mut encoder);
//! queue.submit([encoder.finish()]);
//! # Ok::<(), wgdenoise::Error>(())
//! ```
//!
//! # Features
//!
//! - [`Denoiser::warm_up`] compiles the kernels ahead of the first frame, and [`PipelineFile`]
//!   keeps them on disk between runs.
//! - A pass with [motion](PassDescriptor::motion) averages frames along it to reduce flicker, and
//!   its layers with the same weights.
//! - A [`Schedule`] decides how often a progressive renderer denoises and how much noisy color to
//!   blend in as samples accumulate.
//! - A [`Calibration`] measures the built-in weights on a device and picks the best ones for a time
//!   budget.
//! - [`Denoiser::verify`] compares part of a result with the CPU reference.
//! - [`Weights::from_tza`] reads the weights of Intel Open Image Denoise.
//! - Large images are cut into tiles to stay within [`Options::memory_bytes`].
//!
//! # Requirements
//!
//! wgdenoise uses wgpu 30 and re-exports it as [`wgpu`]; a renderer on the same major version
//! passes its own objects. WebGPU's default limits suffice and no feature is required.
//! [`required_features`] and [`required_limits`] list the optional ones that make it faster and
//! what leaving each out costs. The repository's `docs/embedding.md` covers devices, images and
//! frames in detail; `examples/` has complete programs.
//!
//! # Inside
//!
//! `model` describes the network as data and reads weights files. `plan` decides, from numbers
//! alone, where tensors live and how images are tiled. `ops` has one unit per operator, each paired
//! with a shader and a naive function of the same name in `reference`.

mod denoiser;
mod error;
mod gpu;
mod image;
#[doc(hidden)]
pub mod internals;
pub mod measure;
mod model;
mod network;
mod ops;
pub mod panics;
mod plan;
mod reference;
mod shader;
pub mod tza;

pub use denoiser::Denoiser;
pub use denoiser::frame::{Contents, Denoised, Frame};
pub use denoiser::options::Options;
pub use denoiser::pass::{
    InputScale, LayerFormats, NormalEncoding, Pass, PassDescriptor, PassFormats, PassImage,
    PassLayer, Schedule,
};
pub use denoiser::progress::{FinishedTile, Progress};
pub use denoiser::verify::Verified;
pub use error::{Error, Result};
pub use gpu::device::Gpu;
pub use gpu::kernel_set::KernelSet;
pub use gpu::matrix_shape::{Factor, MatrixShape};
pub use gpu::pipeline_file::PipelineFile;
pub use gpu::precision::Precision;
pub use gpu::requirements::{matrix_features, required_features, required_limits};
pub use image::{Image, Rect};
pub use measure::{Calibration, CallProfile, Cost};
pub use model::{
    Inputs, MainImage, Metadata, OidnSize, Quality, Topology, TransferFunction, Weights,
};
pub use ops::image::{Element, ImageFormat};
pub use ops::tile::Layout;
pub use plan::tiles::{PlacedTile, TilePlan};
pub use wgpu;
