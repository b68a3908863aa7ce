//! Denoises an image in main memory: `cargo run --release --example denoise_image`.

use wgdenoise::{Denoiser, Frame, Gpu, Image, Options, Quality, Weights};

const WIDTH: u32 = 256;
const HEIGHT: u32 = 192;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let truth = image(scene)?;
    let mut random = 1_u32;
    let noisy = image(|x, y| scene(x, y).map(|value| value * light(&mut random)))?;
    // The albedo has no noise. It equals the clean image because the light is white and uniform.
    let albedo = &truth;

    let gpu = Gpu::open(None)?;
    let weights = Weights::builtin(Quality::Fast)?;
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())?;
    let clean = denoiser.denoise(&Frame::new(&noisy).albedo(albedo))?;

    let (before, after) = (error(&noisy, &truth), error(&clean, &truth));
    println!("mean absolute error on {}: {before:.3} noisy, {after:.3} denoised", gpu.info.name);
    assert!(after < before / 3.0, "the denoiser removes most of the noise");
    Ok(())
}

/// Fills an image with linear RGB, row by row from the top left.
fn image(mut pixel: impl FnMut(u32, u32) -> [f32; 3]) -> wgdenoise::Result<Image> {
    let coordinates = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    Image::new(WIDTH, HEIGHT, coordinates.map(|(x, y)| pixel(x, y)).collect())
}

fn scene(x: u32, y: u32) -> [f32; 3] {
    let (u, v) = (x as f32 / WIDTH as f32, y as f32 / HEIGHT as f32);
    if (u - 0.5).hypot(v - 0.5) < 0.25 { [0.8, 0.4, 0.1] } else { [0.2 + 0.3 * u, 0.3, 0.6 * v] }
}

/// The mean of eight random samples with expectation 1.
fn light(state: &mut u32) -> f32 {
    let mut sample = || {
        *state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        -((*state >> 8) as f32 / (1 << 24) as f32).max(1e-6).ln()
    };
    (0..8).map(|_| sample()).sum::<f32>() / 8.0
}

fn error(found: &Image, expected: &Image) -> f32 {
    let values = found.pixels().iter().flatten().zip(expected.pixels().iter().flatten());
    values.map(|(a, b)| (a - b).abs()).sum::<f32>() / (3 * WIDTH * HEIGHT) as f32
}
