//! What the flags say about weights, adapter and options.

use super::args::EngineArgs;
use super::failure::Failure;
use super::pipelines;
use super::weights::Given;
use crate::{Denoiser, Gpu, MatrixShape, Options};

impl EngineArgs {
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

    /// All of it, for what is given, and what the user should know of the weights.
    pub(super) fn denoiser(&self, given: Given) -> Result<(Gpu, Denoiser, Vec<String>), Failure> {
        let (weights, notices) = self.load_weights(given)?;
        let gpu = self.open_gpu()?;
        let options = self.options(&gpu)?;
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options)?;
        Ok((gpu, denoiser, notices))
    }
}
