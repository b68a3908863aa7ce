//! Times frames, after verifying the results.
//!
//! `cargo bench` prints a row per tier, precision and size: the frame on the GPU, the frame with
//! upload and readback, and, with `--operators`, each kernel call. Rows are stored as JSON and
//! compared with those of the last run. `cargo bench -- --check` only verifies, in seconds, and is
//! part of the project's own checks.

mod on_gpu;
mod options;
mod record;
mod verify;

use clap::Parser as _;
use wgdenoise::measure;
use wgdenoise::{Denoiser, Gpu, MatrixShape, Options, Precision, Quality, Result, Weights};

use crate::options::Arguments;
use crate::record::Record;

const TIERS: [(&str, Quality); 3] =
    [("fast", Quality::Fast), ("balanced", Quality::Balanced), ("high", Quality::High)];

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let gpu = Gpu::open(None)?;
    println!("{} ({:?}), {}", gpu.info.name, gpu.info.backend, gpu.info.driver_info);
    let mut record = Record::open(arguments.record.clone(), &gpu.info);
    for (tier, quality) in TIERS {
        for precision in [Precision::F32, Precision::F16] {
            let weights = Weights::builtin(quality)?;
            let matrix = MatrixShape::of(&gpu.adapter, precision);
            let kernels = arguments.kernels(matrix)?;
            let options = Options::default().precision(precision).kernels(kernels).matrix(matrix);
            let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
            let error = verify::error(&denoiser, &weights, precision)?;
            let kernels = denoiser.kernels();
            let name = format!("{tier} {precision:?} {kernels}");
            println!("{name}: within {error:.1e} of the reference");
            if !arguments.check {
                time(&arguments, &gpu, &denoiser, &name, &mut record)?;
            }
        }
    }
    if !arguments.check {
        record.save();
    }
    Ok(())
}

fn time(
    arguments: &Arguments,
    gpu: &Gpu,
    denoiser: &Denoiser,
    name: &str,
    record: &mut Record,
) -> Result<()> {
    for [width, height] in arguments.sizes(&gpu.info) {
        let name = format!("{name} {width}×{height}");
        let frame = measure::measure(denoiser, width, height, arguments.runs)?;
        let on_gpu = |moves| on_gpu::measure(gpu, denoiser, [width, height], moves, arguments.runs);
        record.row(&format!("{name}, on the GPU"), &on_gpu(false)?, frame.flop);
        if arguments.motion {
            record.row(&format!("{name}, on the GPU, with motion"), &on_gpu(true)?, frame.flop);
        }
        record.row(&format!("{name}, with upload and readback"), &frame.seconds, frame.flop);
        if arguments.operators {
            for call in measure::profile(denoiser, width, height, arguments.runs)? {
                record.row(&format!("{name}, {}", call.name), &call.seconds, 2.0 * call.macs);
            }
        }
    }
    Ok(())
}
