//! The whole network on the adapter, comparing GPU with reference, tiled with whole, fewer inputs
//! with zeros, and the caller's encoder with the blocking call.

mod demodulation;
mod device;
mod faults;
mod kernel_pyramid;
mod layers;
mod oidn;
mod overflow;
mod panorama;
mod pass;
mod profile;
mod progress;
mod sequence;
mod shipped;
mod skip;
mod support;
mod tiles;
mod whole;
