//! What the flags say about adapter and options.

use super::args::EngineArgs;
use super::failure::Failure;
use super::pipelines;
use wgdenoise::{Gpu, MatrixShape, Options};

impl EngineArgs {
    /// The adapter of `--adapter`.
    pub(super) fn open_gpu(&self) -> Result<Gpu, Failure> {
        Ok(Gpu::open(self.adapter.as_deref())?)
    }

    /// The engine's own defaults with what the flags change.
    pub(super) fn options(&self, gpu: &Gpu) -> Result<Options, Failure> {
        let default = Options::default();
        let precision = self.precision.map_or(default.precision, Into::into);
        let memory_bytes = self.memory.map_or(default.memory_bytes, |mib| mib << 20);
        let matrix = MatrixShape::of(&gpu.adapter, precision);
        let lacking = || {
            let name = &gpu.info.name;
            Failure::Work(format!("{name} reports no matrices that fit; choose --kernels auto"))
        };
        let kernels = self.kernels.set(matrix).ok_or_else(lacking)?;
        Ok(default
            .precision(precision)
            .memory_bytes(memory_bytes)
            .tile(self.tile)
            .timeout(self.timeout)
            .kernels(kernels)
            .matrix(matrix)
            .skip_clean(!self.no_skip)
            .pipeline_cache(pipelines::open(gpu)))
    }

    /// Both.
    pub(super) fn open(&self) -> Result<(Gpu, Options), Failure> {
        let gpu = self.open_gpu()?;
        let options = self.options(&gpu)?;
        Ok((gpu, options))
    }
}
