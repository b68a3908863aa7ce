//! The time of whole frames, upload and readback included.

use std::time::Instant;

use super::calls::CallProfile;
use super::statistics::{median, repeat};
use crate::error::Result;
use crate::model::macs::macs_per_pixel;
use crate::{Denoiser, Frame, Image};

/// The times of several runs of one frame.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Seconds per run, shortest first.
    pub seconds: Vec<f64>,
    /// The network's floating-point operations per frame; a multiply-accumulate counts as two.
    pub flop: f64,
    /// Planned GPU memory in bytes for tensors and image windows.
    pub memory_bytes: u64,
    /// Tiles per frame.
    pub tiles: usize,
}

impl Timing {
    /// The median run, in seconds.
    #[must_use]
    pub fn median(&self) -> f64 {
        median(&self.seconds)
    }

    /// GFLOP/s of the median run, counting only the network's operations.
    #[must_use]
    pub fn gflops(&self) -> f64 {
        self.flop / self.median() / 1e9
    }
}

/// Denoises a frame with all images that the weights read, once to warm up and then `runs` times
/// (at least once).
///
/// # Errors
/// Fails if the frame does not fit the memory budget or the device fails.
pub fn measure(denoiser: &Denoiser, width: u32, height: u32, runs: u32) -> Result<Timing> {
    let [color, albedo, normal] = test_card(width, height)?;
    let frame = full_frame(&color, &albedo, &normal);
    let seconds = repeat(runs, || {
        let begin = Instant::now();
        denoiser.denoise(&frame)?;
        Ok(begin.elapsed().as_secs_f64())
    })?;
    let inputs = denoiser.weights().metadata().inputs;
    let macs = macs_per_pixel(denoiser.weights().network());
    Ok(Timing {
        seconds,
        flop: 2.0 * macs * f64::from(width) * f64::from(height),
        memory_bytes: denoiser.memory_bytes(width, height, inputs)?,
        tiles: denoiser.tile_plan(width, height, inputs)?.tiles.len(),
    })
}

/// Times each kernel call of the frame that [`measure`] denoises; see [`Denoiser::profile`].
///
/// # Errors
/// Fails like [`Denoiser::profile`].
pub fn profile(
    denoiser: &Denoiser,
    width: u32,
    height: u32,
    runs: u32,
) -> Result<Vec<CallProfile>> {
    let [color, albedo, normal] = test_card(width, height)?;
    denoiser.profile(&full_frame(&color, &albedo, &normal), runs)
}

/// A frame with all three images.
fn full_frame<'a>(color: &'a Image, albedo: &'a Image, normal: &'a Image) -> Frame<'a> {
    Frame::new(color).albedo(albedo).normal(normal)
}

/// Color, albedo and normal made of gradients and a pattern, so that no pixel is special and no
/// block is clean; apart from clean blocks, a network's cost does not depend on its input.
///
/// # Errors
/// Fails if a side is 0 or the images do not fit in memory.
pub fn test_card(width: u32, height: u32) -> Result<[Image; 3]> {
    let at = |x: u32, y: u32| {
        [x as f32 / width as f32, y as f32 / height as f32, ((x ^ y) & 15) as f32 / 15.0]
    };
    let row = |y| (0..width).map(move |x| at(x, y));
    let pixels: Vec<_> = (0..height).flat_map(row).collect();
    let color = pixels.iter().map(|p| p.map(|v| 4.0 * v * v)).collect();
    let normal = pixels.iter().map(|p| p.map(|v| 2.0 * v - 1.0)).collect();
    Ok([
        Image::new(width, height, color)?,
        Image::new(width, height, pixels)?,
        Image::new(width, height, normal)?,
    ])
}
