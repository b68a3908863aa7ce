//! The benchmark's options.

use std::path::PathBuf;

use clap::Parser;
use wgdenoise::wgpu::{AdapterInfo, DeviceType};
use wgdenoise::{Error, KernelSet, MatrixShape, Result};

/// Times the denoiser on the best adapter of this machine.
#[derive(Debug, Parser)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(crate) struct Arguments {
    /// Only verify the results, in seconds
    #[arg(long)]
    pub(crate) check: bool,
    /// Sizes such as 1024x1024 [default: that and, on a GPU, 3840x2160]
    #[arg(long, value_delimiter = ',', value_parser = size)]
    sizes: Vec<[u32; 2]>,
    /// 7680x4320 as well
    #[arg(long = "8k")]
    with_8k: bool,
    /// Every kernel call as well
    #[arg(long)]
    pub(crate) operators: bool,
    /// The frame on the GPU as well with motion, averaged with the last ones
    #[arg(long)]
    pub(crate) motion: bool,
    /// Where the rows are kept and those of the run before are found [default: the target folder]
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Which variant of the convolutions runs
    #[arg(long, default_value = "auto", value_parser = ["auto", "tiled", "wide", "half", "matrix"])]
    kernels: String,
    /// Runs per row; the median is reported
    #[arg(long, default_value_t = 5)]
    pub(crate) runs: u32,
    /// Given by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

impl Arguments {
    /// The requested kernels; for `matrix`, with the shape that the adapter reports.
    pub(crate) fn kernels(&self, matrix: Option<MatrixShape>) -> Result<KernelSet> {
        match (self.kernels.as_str(), matrix) {
            ("tiled", _) => Ok(KernelSet::Tiled),
            ("wide", _) => Ok(KernelSet::Wide),
            ("half", _) => Ok(KernelSet::Half),
            ("matrix", Some(shape)) => Ok(KernelSet::Matrix(shape)),
            ("matrix", None) => {
                Err(Error::Unsupported("the adapter reports no matrices that fit".into()))
            }
            _ => Ok(KernelSet::Auto),
        }
    }

    /// The requested sizes. The default for a CPU driver omits 4K, which would take minutes.
    pub(crate) fn sizes(&self, adapter: &AdapterInfo) -> Vec<[u32; 2]> {
        let mut sizes = self.sizes.clone();
        if sizes.is_empty() {
            sizes.push([1024, 1024]);
            if adapter.device_type != DeviceType::Cpu {
                sizes.push([3840, 2160]);
            }
        }
        sizes.extend(self.with_8k.then_some([7680, 4320]));
        sizes
    }
}

fn size(text: &str) -> std::result::Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.ok_or_else(|| format!("`{text}` is no size; expected for example 1024x1024"))
}
