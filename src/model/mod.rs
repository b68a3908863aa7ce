//! The network, its weights and what it costs: nothing here knows of a GPU.

pub mod cost;
mod file;
pub mod fold;
pub mod fuse;
mod inputs;
mod metadata;
mod shown;
pub mod topology;
mod weights;

pub use inputs::Inputs;
pub use metadata::Metadata;
pub use topology::{INPUT, Layer, Network, Op, Shape, TensorId};
pub use weights::{Params, Quality, Weights};
