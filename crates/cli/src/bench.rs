//! `wgdenoise bench` and `wgdenoise profile`: how fast an adapter denoises, as a whole and step by
//! step.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::cache;
use crate::console::{Console, print, print_json};
use crate::failure::Failure;
use crate::request::Bench;
use crate::session;
use wgdenoise::measure::{self, Timing};
use wgdenoise::{CallProfile, Denoiser, Gpu};
use wgdenoise_files::weights::Subject;

/// Measures whole frames, from images in memory to an image in memory.
pub(crate) fn bench(request: &Bench, console: &Console) -> Result<(), Failure> {
    with_denoiser(request, console, |gpu, denoiser| {
        let timing = measure::measure(denoiser, request.width, request.height, request.runs)?;
        if request.json {
            print_json(&as_json(request, gpu, denoiser, &timing))
        } else {
            print(&as_text(request, gpu, denoiser, &timing))
        }
    })
}

/// Measures each kernel call of a frame with the adapter's timestamps.
pub(crate) fn profile(request: &Bench, console: &Console) -> Result<(), Failure> {
    with_denoiser(request, console, |_, denoiser| {
        let Bench { width, height, runs, .. } = *request;
        print(&table(&measure::profile(denoiser, width, height, runs)?))
    })
}

fn with_denoiser(
    request: &Bench,
    console: &Console,
    measure: impl FnOnce(&Gpu, &Denoiser) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let source = request.weights.source(Subject::ALL)?.expect("a bench has no time budget");
    let weights = source.load()?;
    let (gpu, options) = session::open(&request.device)?;
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
    let notices = source.notice().into_iter().chain(denoiser.take_notices());
    notices.for_each(|notice| console.notice(&notice));
    measure(&gpu, &denoiser)?;
    denoiser.take_notices().iter().for_each(|notice| console.notice(notice));
    cache::keep_pipelines(&gpu, denoiser.options());
    Ok(())
}

fn as_text(request: &Bench, gpu: &Gpu, denoiser: &Denoiser, timing: &Timing) -> String {
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
        request.width,
        request.height,
        timing.tiles,
        timing.memory_bytes.div_ceil(1 << 20),
        timing.median(),
        timing.seconds.len(),
        timing.gflops(),
        megapixels(request) / timing.median(),
    )
}

fn as_json(request: &Bench, gpu: &Gpu, denoiser: &Denoiser, timing: &Timing) -> Value {
    json!({
        "adapter": gpu.info.name,
        "backend": format!("{:?}", gpu.info.backend),
        "kernels": denoiser.kernels().to_string(),
        "precision": format!("{:?}", denoiser.precision()),
        "weights": denoiser.weights().metadata().name,
        "macs_per_pixel": denoiser.weights().macs_per_pixel(),
        "width": request.width,
        "height": request.height,
        "tiles": timing.tiles,
        "memory_bytes": timing.memory_bytes,
        "seconds": timing.seconds,
        "median_seconds": timing.median(),
        "gflops": timing.gflops(),
        "megapixels_per_second": megapixels(request) / timing.median(),
    })
}

fn megapixels(request: &Bench) -> f64 {
    f64::from(request.width) * f64::from(request.height) / 1e6
}

/// A table of kernel calls: median time, share of the sum, and the rates reached.
fn table(rows: &[CallProfile]) -> String {
    let total: f64 = rows.iter().map(CallProfile::median).sum();
    let mut text = format!("{:<18}{:>10}{:>8}{:>10}{:>9}\n", "call", "ms", "%", "GFLOP/s", "GB/s");
    for row in rows {
        let (seconds, name) = (row.median(), &row.name);
        let rate = |amount: f64| format!("{:.1}", amount / seconds / 1e9);
        let (ms, share) = (seconds * 1e3, seconds / total * 100.0);
        let (gflops, gbs) = (rate(2.0 * row.macs), rate(row.bytes));
        let _ = writeln!(text, "{name:<18}{ms:>10.3}{share:>8.1}{gflops:>10}{gbs:>9}");
    }
    let _ = write!(text, "{:<18}{:>10.3}", "sum of medians", total * 1e3);
    text
}
