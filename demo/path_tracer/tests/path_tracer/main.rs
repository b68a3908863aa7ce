//! The renderer of the example `path_tracer`: that what it gives the denoiser is right.

mod bvh;
#[path = "../../src/denoise.rs"]
mod denoise;
mod denoised;
mod energy;
mod files;
mod images;
mod lights;
#[path = "../../src/renderer/mod.rs"]
mod renderer;
mod shaders;
mod support;
