//! Plans made of numbers alone: where tensors live, how an image is cut into tiles, what it takes.

pub mod halo;
pub mod memory;
pub mod storage;
pub mod tiles;

#[cfg(test)]
mod properties_test;
