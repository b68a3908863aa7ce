//! What the flags say about weights, adapter and options.

use std::fs;
use std::path::Path;

use super::args::EngineArgs;
use super::failure::Failure;
use super::pipelines;
use crate::model::tza;
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
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                let weights = match bytes.starts_with(&tza::MAGIC) {
                    true => Weights::from_tza(&bytes, &stem),
                    false => Weights::from_bytes(&bytes),
                };
                weights.map_err(|error| wrong(error.to_string()))
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

fn read(path: &Path) -> Result<Vec<u8>, String> {
    let metadata = fs::metadata(path).map_err(|error| format!("cannot be read: {error}"))?;
    if metadata.len() > MAX_WEIGHTS_BYTES {
        return Err(format!(
            "has {} bytes, and weights files of at most {MAX_WEIGHTS_BYTES} are accepted",
            metadata.len()
        ));
    }
    fs::read(path).map_err(|error| format!("cannot be read: {error}"))
}
