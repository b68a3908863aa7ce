//! `wgdenoise bench`.

use serde_json::json;

use super::args::BenchArgs;
use super::failure::Failure;
use super::weights::Given;
use super::{pipelines, print, profile, report, say};
use wgdenoise::measure::{Timing, measure};
use wgdenoise::{Denoiser, Gpu};

/// Measures whole frames, from images on the CPU to an image on the CPU.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if let Some([noisy, reference]) = args.report() {
        return report::run(args, noisy, reference);
    }
    args.engine.check()?;
    let source = args.engine.source(Given::ALL)?;
    let weights = source.load()?;
    let (gpu, options) = args.engine.open()?;
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
    source.notice().into_iter().chain(denoiser.take_notices()).for_each(|notice| say(&notice));
    let result = if args.profile {
        profile::table(&denoiser, args)?
    } else {
        let timing = measure(&denoiser, args.width, args.height, args.runs)?;
        let report = if args.json { as_json } else { as_text };
        report(args, &gpu, &denoiser, &timing)
    };
    denoiser.take_notices().iter().for_each(|notice| say(notice));
    pipelines::keep(&gpu, denoiser.options());
    print(&result)
}

fn as_text(args: &BenchArgs, gpu: &Gpu, denoiser: &Denoiser, timing: &Timing) -> String {
    let weights = denoiser.weights();
    let (fastest, slowest) = (timing.seconds[0], timing.seconds[timing.seconds.len() - 1]);
    format!(
        "{} ({:?}), kernels {}, tensors in {:?}\n\
         weights `{}`, {:.1} kMAC per pixel, {}\n\
         {}×{}, tiles: {}, planned memory: {} MiB: median {:.4} s ({fastest:.4} to {slowest:.4} in {} runs), \
         {:.1} GFLOP/s, {:.3} megapixels/s",
        gpu.info.name,
        gpu.info.backend,
        denoiser.kernels(),
        denoiser.precision(),
        weights.metadata().name,
        weights.macs_per_pixel() / 1e3,
        weights.metadata().inputs,
        args.width,
        args.height,
        timing.tiles,
        timing.memory_bytes.div_ceil(1 << 20),
        timing.median(),
        timing.seconds.len(),
        timing.gflops(),
        megapixels(args) / timing.median(),
    )
}

fn as_json(args: &BenchArgs, gpu: &Gpu, denoiser: &Denoiser, timing: &Timing) -> String {
    json!({
        "adapter": gpu.info.name,
        "backend": format!("{:?}", gpu.info.backend),
        "kernels": denoiser.kernels().to_string(),
        "precision": format!("{:?}", denoiser.precision()),
        "weights": denoiser.weights().metadata().name,
        "macs_per_pixel": denoiser.weights().macs_per_pixel(),
        "width": args.width,
        "height": args.height,
        "tiles": timing.tiles,
        "memory_bytes": timing.memory_bytes,
        "seconds": timing.seconds,
        "median_seconds": timing.median(),
        "gflops": timing.gflops(),
        "megapixels_per_second": megapixels(args) / timing.median(),
    })
    .to_string()
}

fn megapixels(args: &BenchArgs) -> f64 {
    f64::from(args.width) * f64::from(args.height) / 1e6
}
