//! Tests of the path tracer: what it hands the denoiser is correct.

mod bvh;
mod command;
mod denoised;
mod energy;
mod files;
mod images;
mod lights;
mod motion;
mod shaders;
mod stage;
mod support;
mod temporal;
