//! The whole network on the adapter: against the reference, tiled against whole, with fewer
//! inputs against zeros, in a caller's encoder against the blocking call.

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
