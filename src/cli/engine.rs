//! What the flags say about weights, adapter and options.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::args::EngineArgs;
use super::failure::Failure;
use super::pipelines;
use crate::{Denoiser, Gpu, MatrixShape, Options, Weights};

/// The longest weights file that is read.
const MAX_WEIGHTS_BYTES: u64 = 1 << 30;

impl EngineArgs {
    /// The weights of `--weights` or `--quality`.
    pub(super) fn load_weights(&self) -> Result<Weights, Failure> {
        match &self.weights {
            None => Ok(Weights::builtin(self.quality.into())?),
            Some(path) => {
                let wrong = |what: String| Failure::Work(format!("{}: {what}", path.display()));
                let bytes = read(path).map_err(wrong)?;
                Weights::from_bytes(&bytes).map_err(|error| wrong(error.to_string()))
            }
        }
    }

    /// The adapter of `--adapter`.
    pub(super) fn open_gpu(&self) -> Result<Gpu, Failure> {
        Ok(Gpu::open(self.adapter.as_deref())?)
    }

    /// The engine's own defaults with what the flags change.
    pub(super) fn options(&self, gpu: &Gpu) -> Result<Options, Failure> {
        let default = Options::default();
        let precision = self.precision.map_or(default.precision, Into::into);
        let matrix = MatrixShape::of(&gpu.adapter, precision);
        let lacking = || {
            let name = &gpu.info.name;
            Failure::Work(format!("{name} reports no matrices that fit; choose --kernels auto"))
        };
        Ok(Options {
            precision,
            memory_bytes: self.memory.map_or(default.memory_bytes, |mib| mib << 20),
            tile: self.tile,
            timeout: self.timeout,
            kernels: self.kernels.set(matrix).ok_or_else(lacking)?,
            matrix,
            skip_clean: !self.no_skip,
            pipeline_cache: pipelines::open(gpu),
        })
    }

    /// All of it.
    pub(super) fn denoiser(&self) -> Result<(Gpu, Denoiser), Failure> {
        let weights = self.load_weights()?;
        let gpu = self.open_gpu()?;
        let options = self.options(&gpu)?;
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
        Ok((gpu, denoiser))
    }
}

/// Not more than the limit, even of what has no length, such as a pipe or a device.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |error: io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(cannot)?;
    let length = file.metadata().map_err(cannot)?.len();
    let mut bytes = Vec::new();
    if length <= MAX_WEIGHTS_BYTES {
        file.take(MAX_WEIGHTS_BYTES + 1).read_to_end(&mut bytes).map_err(cannot)?;
    }
    if length.max(bytes.len() as u64) > MAX_WEIGHTS_BYTES {
        return Err(format!(
            "is longer than {MAX_WEIGHTS_BYTES} bytes, the most that is accepted of weights"
        ));
    }
    Ok(bytes)
}
