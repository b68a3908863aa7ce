//! The network, its weights and its cost. Nothing here knows about a GPU.

mod encoding;
mod file;
pub mod fold;
pub mod fuse;
mod inputs;
pub mod macs;
mod metadata;
mod oidn;
pub mod operators;
mod params;
mod shown;
pub mod topology;
pub mod tza;
mod weights;

pub use encoding::{Encoding, TransferFunction};
pub use inputs::Inputs;
pub use metadata::{MainImage, Metadata, Topology};
pub use oidn::OidnSize;
pub use operators::Op;
pub use params::Params;
pub use topology::{INPUT, LOGITS, Layer, Network, TensorId, TensorShape};
pub use weights::{Quality, Weights};
