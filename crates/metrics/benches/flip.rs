//! How long FLIP takes for two pictures of 3840×2160 pixels: `cargo bench -p wgdenoise-metrics`.

use std::time::Instant;

use wgdenoise::{Image, Result};
use wgdenoise_metrics::{PIXELS_PER_DEGREE, flip};

const SIZE: [u32; 2] = [3840, 2160];

fn main() -> Result<()> {
    let (image, reference) = (picture(0.2)?, picture(0.0)?);
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let found = flip(&image, &reference, PIXELS_PER_DEGREE)?;
        best = best.min(start.elapsed().as_secs_f64());
        println!("mean error {:.6}", found.mean);
    }
    println!("{best:.2} s, the best of 3");
    Ok(())
}

/// A ramp of display values with noise of this height, from a fixed sequence.
fn picture(noise: f32) -> Result<Image> {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        noise * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5)
    };
    let [width, height] = SIZE;
    let ramp =
        |i: u32| [(i % width) as f32 / width as f32, (i / width) as f32 / height as f32, 0.4];
    let pixels = (0..width * height).map(|i| ramp(i).map(|v| v + next())).collect();
    Image::new(width, height, pixels)
}
