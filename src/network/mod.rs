//! A network on a device: compiled once, then bound to the tensors and images of a tile.

pub(crate) mod bind;
pub(crate) mod call;
pub(crate) mod compile;
mod pyramid;
#[cfg(test)]
mod traffic_test;
