//! The renderer of the example `path_tracer`: that what it gives the denoiser is right.
#![cfg(feature = "cli")]

mod bvh;
mod energy;
mod files;
mod images;
mod lights;
#[path = "../../examples/path_tracer/renderer/mod.rs"]
mod renderer;
mod shaders;
mod support;
