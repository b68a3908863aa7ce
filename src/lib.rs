//! wgdenoise

#[cfg(feature = "cli")]
pub mod cli;
pub mod denoiser;
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
pub mod reference;
mod requirements;
mod window;

pub use denoiser::Denoiser;
pub use error::{Error, Result};
pub use frame::Frame;
pub use gpu::Gpu;
pub use image::Image;
pub use model::{Inputs, Quality, Weights};
pub use ops::tile::Layout;
pub use options::{KernelSet, Options, Precision};
pub use pass::{Pass, PassDescriptor, PassImage};
pub use requirements::{required_features, required_limits};
pub use wgpu;
