//! Removes Monte Carlo noise from path-traced images on any GPU: a U-Net in hand-written WGSL,
//! dispatched through wgpu, with trained weights built in.
//!
//! Two objects do the work. A [`Denoiser`] holds compiled kernels and weights on a device of
//! the caller's, and serves images of any size; its [`denoise`](Denoiser::denoise) takes images
//! on the CPU and waits for the result. A [`Pass`] is a denoiser bound to a size and to images
//! on the GPU: its [`encode`](Pass::encode) records into the caller's command encoder, creates
//! nothing and cannot fail.
//!
//! Colour is linear and scene-referred, in any exposure. Albedo (in `[0, 1]`) and normal (in
//! `[−1, 1]`) make the result better and may be absent.
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
//! let frame = Frame { color: &color, albedo: None, normal: None, input_scale: None };
//! let clean = denoiser.denoise(&frame, &mut |done, of| println!("{done} of {of} tiles"))?;
//! assert_eq!(clean.size(), (64, 48));
//! # Ok::<(), wgdenoise::Error>(())
//! ```
//!
//! # A pass inside a renderer
//!
//! ```
//! use wgdenoise::{Denoiser, Gpu, Layout, Options, PassDescriptor, PassImage, Quality, Weights};
//! # use wgdenoise::wgpu;
//! # let Gpu { device, queue, .. } = Gpu::open(None)?;
//! # let size = 320 * 200 * 12;
//! # let buffer = || device.create_buffer(&wgpu::BufferDescriptor { label: None, size,
//! #     usage: wgpu::BufferUsages::STORAGE, mapped_at_creation: false });
//! # let (noisy, clean) = (buffer(), buffer());
//! // Once: `device` and `queue` are the renderer's own.
//! let weights = Weights::builtin(Quality::Fast)?;
//! let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default())?;
//! // Per size: `noisy` and `clean` are storage buffers of RGB 32-bit floats.
//! let image = |buffer| PassImage::Buffer { buffer, layout: Layout::packed(320) };
//! let pass = denoiser.pass(&PassDescriptor {
//!     width: 320,
//!     height: 200,
//!     color: image(&noisy),
//!     albedo: None,
//!     normal: None,
//!     output: image(&clean),
//!     input_scale: None,
//! })?;
//! // Per frame, between the renderer's own passes:
//! let mut encoder = device.create_command_encoder(&Default::default());
//! pass.encode(&mut encoder);
//! queue.submit([encoder.finish()]);
//! # Ok::<(), wgdenoise::Error>(())
//! ```
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

mod blocking;
mod calibration;
#[cfg(feature = "cli")]
pub mod cli;
mod denoiser;
pub mod error;
#[cfg(feature = "cli")]
pub mod files;
mod frame;
mod gpu;
mod graph;
mod image;
pub mod kernel;
pub mod metrics;
pub mod model;
pub mod ops;
mod options;
mod pass;
pub mod plan;
mod profile;
pub mod reference;
mod requirements;
mod tile_graph;
pub mod timing;
mod unsafe_calls;
mod window;

pub use calibration::{Calibration, Cost};
pub use denoiser::Denoiser;
pub use error::{Error, Result};
pub use frame::Frame;
pub use gpu::Gpu;
pub use image::Image;
pub use model::{Inputs, Quality, Weights};
pub use ops::matrix::MatrixShape;
pub use ops::tile::Layout;
pub use options::{KernelSet, Options, Precision};
pub use pass::{Pass, PassDescriptor, PassImage};
pub use profile::CallProfile;
pub use requirements::{matrix_features, required_features, required_limits};
pub use wgpu;
