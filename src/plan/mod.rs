//! Plans made of numbers alone: where tensors live, how an image is cut into tiles.

pub mod halo;
pub mod storage;
pub mod tiles;
