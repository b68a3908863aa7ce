//! The whole network on the adapter: against the reference, tiled against whole, with fewer
//! inputs against zeros, in a caller's encoder against the blocking call.

#[path = "../common/mod.rs"]
mod common;

mod device;
mod faults;
mod oidn;
mod overflow;
mod pass;
mod profile;
mod shipped;
mod skip;
mod support;
mod tiles;
mod whole;
