//! The network, its weights and what it costs: nothing here knows of a GPU.

pub mod topology;

pub use topology::{INPUT, Layer, Network, Op, Shape, TensorId};
