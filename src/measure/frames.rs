//! How long whole frames take, upload and readback included.

use std::time::Instant;

use super::calls::CallProfile;
use super::statistics::{median, repeat};
use crate::error::Result;
use crate::model::cost::macs_per_pixel;
use crate::{Denoiser, Frame, Image};

/// Times of several runs of one frame.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Seconds per run, shortest first.
    pub seconds: Vec<f64>,
    /// Operations of the network per frame; a multiply-accumulate is two.
    pub flop: f64,
    /// GPU memory that tensors and image windows are planned to take, in bytes.
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

    /// Operations per second of the median run, in 10⁹; only the network's are counted.
    #[must_use]
    pub fn gflops(&self) -> f64 {
        self.flop / self.median() / 1e9
    }
}

/// Denoises a frame of all images that the weights can read, once to warm up and then `runs`
/// times (at least once).
///
/// # Errors
/// If the frame does not fit the memory budget or the device fails.
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

/// Each kernel call of the frame that [`measure`] denoises; see [`Denoiser::profile`].
///
/// # Errors
/// As for [`Denoiser::profile`].
pub fn profile(
    denoiser: &Denoiser,
    width: u32,
    height: u32,
    runs: u32,
) -> Result<Vec<CallProfile>> {
    let [color, albedo, normal] = test_card(width, height)?;
    denoiser.profile(&full_frame(&color, &albedo, &normal), runs)
}

/// A frame of all three images.
fn full_frame<'a>(color: &'a Image, albedo: &'a Image, normal: &'a Image) -> Frame<'a> {
    Frame::new(color).albedo(albedo).normal(normal)
}

/// Colour, albedo and normal: gradients and a pattern, so that no pixel is special and no block
/// clean; else what a network costs does not depend on its input.
///
/// # Errors
/// If a side is 0 or too large.
pub fn test_card(width: u32, height: u32) -> Result<[Image; 3]> {
    let at = |i: u32| {
        let (x, y) = (i % width, i / width);
        [x as f32 / width as f32, y as f32 / height as f32, ((x ^ y) & 15) as f32 / 15.0]
    };
    let pixels: Vec<_> = (0..width * height).map(at).collect();
    let color = pixels.iter().map(|p| p.map(|v| 4.0 * v * v)).collect();
    let normal = pixels.iter().map(|p| p.map(|v| 2.0 * v - 1.0)).collect();
    Ok([
        Image::new(width, height, color)?,
        Image::new(width, height, pixels)?,
        Image::new(width, height, normal)?,
    ])
}
