//! Tests of the path tracer: the denoiser receives correct images.

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
