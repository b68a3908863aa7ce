//! Runs wgdenoise's network on Burn's wgpu backend: first a check on known input, then the timing.
//!
//! Prints one line of JSON: the adapter, its shader compiler, the largest difference from the
//! expected output and the seconds of each run. Only the network is timed, with input and output on
//! the device; each run waits for the device.

mod unet;
mod weights;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use burn::tensor::{DType, Device, DeviceKind, Tensor, TensorData};
use clap::{Parser, ValueEnum};
use safetensors::SafeTensors;
use unet::UNet;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

#[derive(Parser)]
struct Args {
    /// A weights file of wgdenoise.
    #[arg(long)]
    weights: PathBuf,
    /// A safetensors file with the F32 tensors `input` and `output` in NCHW order.
    #[arg(long)]
    check: PathBuf,
    #[arg(long)]
    width: usize,
    #[arg(long)]
    height: usize,
    /// Timed runs, after one that warms up.
    #[arg(long, default_value_t = 1)]
    runs: usize,
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    precision: Precision,
}

#[derive(Clone, Copy, ValueEnum)]
enum Precision {
    F32,
    F16,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<serde_json::Value> {
    let device = Device::wgpu(DeviceKind::DefaultDevice);
    let dtype = match args.precision {
        Precision::F32 => DType::F32,
        Precision::F16 => DType::F16,
    };
    let net = from_file(&args.weights, |data| UNet::load(data, dtype, &device))?;
    let error = from_file(&args.check, |data| largest_error(&net, data, dtype, &device))?;
    let seconds = time(&net, args, dtype, &device)?;
    let identity = device.identity().ok_or("Burn does not name its device")?;
    Ok(serde_json::json!({
        "adapter": identity.name,
        "compiler": identity.fingerprint,
        "max_error": error,
        "seconds": seconds,
    }))
}

/// Parses a file with `parse`; errors name the file.
fn from_file<T>(path: &Path, parse: impl Fn(&[u8]) -> Result<T>) -> Result<T> {
    let named = |error: Box<dyn Error>| format!("{}: {error}", path.display());
    let data = std::fs::read(path).map_err(|error| named(error.into()))?;
    Ok(parse(&data).map_err(named)?)
}

/// The largest error of the network's output against the file's; NaN counts as infinite.
fn largest_error(net: &UNet, file: &[u8], dtype: DType, device: &Device) -> Result<f32> {
    let file = SafeTensors::deserialize(file)?;
    let (input, shape) = weights::floats(&file, "input")?;
    let (expected, _) = weights::floats(&file, "output")?;
    let input = Tensor::<4>::from_data(TensorData::new(input, shape), device).cast(dtype);
    let found = net.forward(input).cast(DType::F32).try_into_data()?;
    let differences = found.as_slice::<f32>()?.iter().zip(&expected).map(|(a, b)| (a - b).abs());
    Ok(differences.fold(0.0, |most, d| if d.is_nan() { f32::INFINITY } else { most.max(d) }))
}

/// Seconds per run. The input's values do not matter, because the network does the same work for
/// all.
fn time(net: &UNet, args: &Args, dtype: DType, device: &Device) -> Result<Vec<f64>> {
    let shape = [1, net.input_channels(), args.height, args.width];
    let input = Tensor::<4>::full(shape, 0.5, device).cast(dtype);
    let run = || -> Result<f64> {
        device.sync()?;
        let begin = Instant::now();
        let output = net.forward(input.clone());
        device.sync()?;
        let seconds = begin.elapsed().as_secs_f64();
        drop(output);
        Ok(seconds)
    };
    run()?;
    (0..args.runs).map(|_| run()).collect()
}
