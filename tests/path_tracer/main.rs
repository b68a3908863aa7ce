//! The renderer of the example `path_tracer`: that what it gives the denoiser is right.
#![cfg(feature = "cli")]

mod bvh;
#[path = "../../examples/path_tracer/denoise.rs"]
mod denoise;
mod denoised;
mod energy;
mod files;
mod images;
mod lights;
#[path = "../../examples/path_tracer/renderer/mod.rs"]
mod renderer;
mod shaders;
mod support;
