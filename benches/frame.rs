//! Whole frames at 1024×1024 and 3840×2160, verified before they are timed.
//!
//! `cargo bench` prints one row per quality, precision and size; `cargo bench -- --check` only
//! verifies, in seconds, and is part of the project's own checks.

use wgdenoise::timing::measure;
use wgdenoise::{
    Denoiser, Frame, Gpu, Image, Options, Precision, Quality, Result, Weights, reference,
};

const QUALITIES: [(&str, Quality); 2] = [("fast", Quality::Fast), ("balanced", Quality::Balanced)];
const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F16];
const SIZES: [(u32, u32); 2] = [(1024, 1024), (3840, 2160)];
const RUNS: u32 = 5;

fn main() -> Result<()> {
    let check = std::env::args().any(|argument| argument == "--check");
    let gpu = Gpu::open(None)?;
    println!("{} ({:?}), {}", gpu.info.name, gpu.info.backend, gpu.info.driver_info);
    for (name, quality) in QUALITIES {
        for precision in PRECISIONS {
            let weights = Weights::builtin(quality)?;
            let options = Options { precision, ..Options::default() };
            let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
            let error = verify(&denoiser, &weights, precision)?;
            println!("{name} {precision:?}: within {error:.1e} of the reference");
            if !check {
                time(&denoiser, &format!("{name} {precision:?}"))?;
            }
        }
    }
    Ok(())
}

fn time(denoiser: &Denoiser, name: &str) -> Result<()> {
    for (width, height) in SIZES {
        let timing = measure(denoiser, width, height, RUNS)?;
        let [fastest, slowest] = [0, timing.seconds.len() - 1].map(|i| timing.seconds[i]);
        println!(
            "{name} {width}×{height}: median {:.4} s ({fastest:.4} to {slowest:.4}), {:.1} GFLOP/s, \
             {} tiles, {} MiB",
            timing.median(),
            timing.gflops(),
            timing.tiles,
            timing.memory_bytes >> 20,
        );
    }
    Ok(())
}

/// The largest difference from the CPU reference in the transfer domain; panics if it is more
/// than the precision explains.
fn verify(denoiser: &Denoiser, weights: &Weights, precision: Precision) -> Result<f64> {
    let color = noise(33, 17)?;
    let frame =
        Frame { color: &color, albedo: Some(&color), normal: Some(&color), input_scale: None };
    let found = denoiser.denoise(&frame, &mut |_, _| {})?;
    let scale = reference::autoexposure(&color);
    let input = reference::input_process(&color, Some(&color), Some(&color), scale, 16);
    let output = reference::run(weights.network(), |layer| weights.params(layer), &input);
    let expected = reference::output_process(&output, scale, 33, 17);
    let encode = |v: &f32| reference::pu(f64::from(*v) * f64::from(scale));
    let values = found.pixels().iter().flatten().zip(expected.pixels().iter().flatten());
    let error = values.map(|(a, b)| (encode(a) - encode(b)).abs()).fold(0.0, f64::max);
    // As for the whole network in the tests. Measured: 1e-7 and 3e-4.
    let allowed = if precision == Precision::F32 { 4e-6 } else { 6e-3 };
    let finite = found.pixels().iter().flatten().all(|v| v.is_finite());
    assert!(finite && error <= allowed, "{error} from the reference, allowed {allowed}");
    Ok(error)
}

/// Values in `[0, 1)` without any pattern, the same in every run.
fn noise(width: u32, height: u32) -> Result<Image> {
    let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    let pixel = |i: u32| [value(3 * i + 1), value(3 * i + 2), value(3 * i + 3)];
    Image::new(width, height, (0..width * height).map(pixel).collect())
}
