//! Removes Monte Carlo noise from path-traced images on any GPU: a U-Net in hand-written WGSL,
//! dispatched through wgpu, with trained weights built in.
//!
//! Two objects do the work. A [`Denoiser`] holds compiled kernels and weights on a device of
//! the caller's, and serves images of any size; its [`denoise`](Denoiser::denoise) takes images
//! on the CPU and waits for the result. A [`Pass`] is a denoiser bound to a size and to images
//! on the GPU: its [`encode`](Pass::encode) records into the caller's command encoder, creates
//! nothing and cannot fail.
//!
//! Colour is linear and scene-referred, in any exposure, unless weights say otherwise
//! ([`model::TransferFunction`]). Albedo (in `[0, 1]`) and normal (in
//! `[−1, 1]`) make the result better and may be absent. Pixels that are not finite are filled from
//! their neighbours, and lone fireflies darkened, before the network sees them
//! ([`reference::repair`]); what comes out is finite and, but for directions, not negative, unless
//! noisy colour that is negative is blended in ([`Pass::set_blend`]).
//!
//! # An image on the CPU
//!
//! ```
//! use wgdenoise::{Denoiser, Frame, Gpu, Image, Options, Quality, Weights};
//!
//! let gpu = Gpu::open(None)?;
//! let weights = Weights::builtin(Quality::Fast)?;
//! let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())?;
//! let color = Image::filled(64, 48, [0.5, 0.4, 0.3])?;
//! let frame = Frame::new(&color);
//! let clean = denoiser.denoise(&frame, &mut |done, of| println!("{done} of {of} tiles"))?;
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
//! // Once: `device` and `queue` are the renderer's own.
//! let weights = Weights::builtin(Quality::Fast)?;
//! let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default())?;
//! // Per size: the renderer's textures, or its buffers, or a mix.
//! let pass = denoiser.pass(&PassDescriptor {
//!     albedo: Some(PassImage::Texture(&albedo)),
//!     normal: Some(PassImage::Texture(&normal)),
//!     ..PassDescriptor::new(320, 200, PassImage::Texture(&noisy), PassImage::Texture(&clean))
//! })?;
//! // Per frame, between the renderer's own passes:
//! let mut encoder = device.create_command_encoder(&Default::default());
//! pass.encode(&mut encoder);
//! queue.submit([encoder.finish()]);
//! # Ok::<(), wgdenoise::Error>(())
//! ```
//!
//! wgdenoise is built on wgpu 30 and re-exports it as [`wgpu`]: a renderer on the same major version
//! passes its own objects. The device needs no feature and no limit beyond WebGPU's defaults, but
//! is faster with what [`required_features`] and [`required_limits`] name; each says what happens
//! without it. [`Denoiser::warm_up`] compiles ahead, and a [`Schedule`] says when to denoise
//! pictures that accumulate, and how much of the noisy colour to blend in.
//!
//! # A time budget
//!
//! A [`Calibration`] measures what the built-in weights take on a device and chooses among them.
//!
//! # How it is built
//!
//! [`model`] describes the network as data and reads weights files; [`plan`] decides in numbers
//! alone where tensors live and how images are cut into tiles; [`ops`] has one unit per
//! operator, each with a shader and, in [`mod@reference`], a naive function of the same name.

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
pub use denoiser::frame::Frame;
pub use denoiser::options::Options;
pub use denoiser::pass::{
    InputScale, NormalEncoding, Pass, PassDescriptor, PassFormats, PassImage, Schedule,
};
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
pub use wgpu;
