//! What a caller can choose.

use std::time::Duration;

use crate::error::{Error, Result};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::gpu::precision::Precision;

/// What [`Options::kernels`] came to, and what the caller should know of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Chosen {
    pub(crate) kernels: KernelSet,
    pub(crate) notices: Vec<String>,
}

/// How a [`Denoiser`](crate::Denoiser) works.
#[derive(Clone, Debug)]
pub struct Options {
    /// How tensors are stored; 16-bit float unless said.
    pub precision: Precision,
    /// Most bytes of GPU memory for tensors and, in the blocking call, images; 2 GiB unless
    /// said. The adapter's limits bound tiles as well.
    pub memory_bytes: u64,
    /// Most pixels of a tile's side, overlap included. `None` picks the largest tile within the
    /// budget whose dispatches are short enough for a display or a watchdog that waits (below 0.2 s
    /// where convolutions reach 0.5 TFLOP/s; CPU drivers have neither).
    pub tile: Option<u32>,
    /// Longest wait for one submission of the blocking call, which has at most 50 GMAC on a GPU (on
    /// a CPU driver, a layer of a whole tile), before the device counts as hung. `None`, unless said,
    /// is a minute, and ten on CPU drivers.
    pub timeout: Option<Duration>,
    /// Which variant of the convolutions runs.
    pub kernels: KernelSet,
    /// Whether blocks of 16×16 pixels that have no noise, such as an empty background, keep
    /// their colour and skip the network; see [`ops::activity`](crate::ops::activity). The
    /// plain kernels never skip.
    pub skip_clean: bool,
    /// The matrices that `Auto` may use: [`MatrixShape::of`] the adapter, since a device does not
    /// know. `None` unless said: no matrices.
    pub matrix: Option<MatrixShape>,
    /// Where the driver looks compiled kernels up and adds what it compiles: a cache of the
    /// denoiser's device, which needs the feature `PIPELINE_CACHE` (Vulkan alone has it). `None`
    /// unless said. What [`get_data`](wgpu::PipelineCache::get_data) says afterwards is the
    /// caller's to keep, for [`create_pipeline_cache`](wgpu::Device::create_pipeline_cache) in the
    /// next run: this library reads and writes no file by itself.
    pub pipeline_cache: Option<wgpu::PipelineCache>,
}

impl Options {
    /// The set that runs: `Auto` replaced by the first of `Simd`, `Matrix` and `Tiled` that
    /// `runs`, and `Matrix` by `Tiled` where its `test` fails.
    ///
    /// # Errors
    /// If the set does not run on the device called `name`.
    pub(crate) fn choose(
        &self,
        name: &str,
        runs: impl Fn(KernelSet) -> bool,
        test: impl FnOnce(MatrixShape) -> Result<()>,
    ) -> Result<Chosen> {
        let matrix = self.matrix.map(KernelSet::Matrix);
        let fastest = [Some(KernelSet::Simd), matrix].into_iter().flatten().find(|set| runs(*set));
        let kernels = match self.kernels {
            KernelSet::Auto => fastest.unwrap_or(KernelSet::Tiled),
            set if runs(set) => set,
            set => {
                return Err(Error::Adapter(format!(
                    "the {set} kernels do not run on {name}; they need {}; choose Auto",
                    set.needs()
                )));
            }
        };
        let failure = match kernels {
            KernelSet::Matrix(shape) => test(shape).err(),
            _ => None,
        };
        let notice = |error| format!("the matrix kernels fail on {name}, Tiled runs: {error}");
        Ok(match failure {
            None => Chosen { kernels, notices: Vec::new() },
            Some(error) => Chosen { kernels: KernelSet::Tiled, notices: vec![notice(error)] },
        })
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            precision: Precision::F16,
            memory_bytes: 2 << 30,
            tile: None,
            timeout: None,
            kernels: KernelSet::Auto,
            skip_clean: true,
            matrix: None,
            pipeline_cache: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::matrix_shape::Factor;

    const SHAPE: MatrixShape = MatrixShape { side: 16, factor: Factor::F16, lanes: 32 };
    const MATRIX: KernelSet = KernelSet::Matrix(SHAPE);

    fn choose(kernels: KernelSet, runs: &[KernelSet], passes: bool) -> Result<Chosen> {
        let test = |shape| {
            assert_eq!(shape, SHAPE);
            let failure = || Error::Device("2 of 3 results are wrong".into());
            if passes { Ok(()) } else { Err(failure()) }
        };
        let options = Options { kernels, matrix: Some(SHAPE), ..Options::default() };
        options.choose("GPU 7", |set| runs.contains(&set), test)
    }

    #[test]
    fn auto_is_simd_before_matrix_before_tiled() {
        let (simd, tiled) = (KernelSet::Simd, KernelSet::Tiled);
        for (runs, expected) in
            [(&[simd, MATRIX, tiled][..], simd), (&[MATRIX, tiled], MATRIX), (&[tiled], tiled)]
        {
            let chosen = choose(KernelSet::Auto, runs, true).unwrap();
            assert_eq!(chosen, Chosen { kernels: expected, notices: Vec::new() });
        }
    }

    #[test]
    fn matrix_kernels_that_fail_their_test_are_replaced_and_the_caller_is_told() {
        for kernels in [KernelSet::Auto, MATRIX] {
            let chosen = choose(kernels, &[MATRIX, KernelSet::Tiled], false).unwrap();
            assert_eq!(chosen.kernels, KernelSet::Tiled);
            assert!(chosen.notices[0].contains("2 of 3 results are wrong"), "{chosen:?}");
        }
    }

    #[test]
    fn a_set_that_does_not_run_is_an_error_that_says_what_it_needs() {
        for (kernels, word) in
            [(KernelSet::Simd, "SUBGROUP"), (MATRIX, "subgroups of its one size")]
        {
            let error = choose(kernels, &[KernelSet::Tiled], true).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("GPU 7"), "{error}");
        }
    }
}
