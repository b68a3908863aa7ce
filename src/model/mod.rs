//! The network, its weights and what it costs: nothing here knows of a GPU.

pub mod cost;
mod encoding;
mod file;
pub mod fold;
pub mod fuse;
mod inputs;
mod metadata;
mod oidn;
mod shown;
pub mod topology;
pub mod tza;
mod weights;

pub use encoding::{Encoding, TransferFunction};
pub use inputs::Inputs;
pub use metadata::{MainImage, Metadata, Topology};
pub use oidn::OidnSize;
pub use topology::{INPUT, Layer, Network, Op, Shape, TensorId};
pub use weights::{Params, Quality, Weights};
