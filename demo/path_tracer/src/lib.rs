//! A small progressive path tracer that denoises every frame it draws.
//!
//! [`renderer`] draws a scene into textures and knows nothing of the denoiser; [`stage`] moves the
//! scene. [`denoise`] is all the code that a renderer needs to add wgdenoise. [`exr`] writes the
//! images into files that the `wgdenoise` command reads.

pub mod denoise;
pub mod exr;
pub mod renderer;
pub mod stage;
