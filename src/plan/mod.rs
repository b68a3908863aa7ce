//! Planning from numbers alone: where tensors live, how an image is tiled, and what it costs.

pub mod halo;
pub mod memory;
pub mod storage;
pub mod tiles;

#[cfg(test)]
mod properties_test;
