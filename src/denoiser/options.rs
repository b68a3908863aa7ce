//! The choices a caller makes for a denoiser.

use std::time::Duration;

use crate::error::{Error, Result};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::gpu::precision::Precision;

/// The kernels that [`Options::kernels`] resolves to, and notices about them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Chosen {
    pub(crate) kernels: KernelSet,
    pub(crate) notices: Vec<String>,
}

/// Settings of a [`Denoiser`](crate::Denoiser). Start from the default:
///
/// ```
/// use wgdenoise::{Options, Precision};
///
/// let options = Options::default().precision(Precision::F32).memory_bytes(512 << 20);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// How tensors are stored: 16-bit float by default.
    pub precision: Precision,
    /// GPU memory budget in bytes for tensors and, in the blocking call, images: 2 GiB by default.
    /// Calls that run at once each take their own. The adapter's limits restrict tiles further.
    pub memory_bytes: u64,
    /// Longest side of a tile in pixels, overlap included. `None`, the default, picks the largest
    /// tile within the budget whose dispatches stay short enough for a display or watchdog: below
    /// 0.2 s on an adapter whose convolutions reach 0.5 TFLOP/s. CPU drivers have neither, so only
    /// the budget counts.
    pub tile: Option<u32>,
    /// Longest wait for one submission of the blocking call before the device counts as hung. A
    /// submission holds at most 50 GMAC on a GPU, or one layer of a tile on a CPU driver. `None`,
    /// the default, is one minute, or ten on CPU drivers.
    pub timeout: Option<Duration>,
    /// Which convolution kernels run.
    pub kernels: KernelSet,
    /// Whether blocks of 16×16 pixels in constant surroundings, such as an empty background, keep
    /// their color and skip the network: `true` by default. The plain kernels never skip.
    pub skip_clean: bool,
    /// Whether the blocking call keeps a frame's GPU memory until the next frame, which reuses it
    /// if it has the same size and images: `true` by default. Otherwise every frame allocates and
    /// clears its memory, on CPU drivers for an eighth to a sixth of its time.
    pub keep_memory: bool,
    /// The matrix shape that `Auto` may use. Only the adapter knows it, so pass the result of
    /// [`MatrixShape::of`]. `None`, the default, rules the matrix kernels out.
    pub matrix: Option<MatrixShape>,
    /// A cache in which the driver finds compiled kernels and stores new ones. It must belong to
    /// the denoiser's device, which needs the feature `PIPELINE_CACHE` (Vulkan only). `None` by
    /// default. [`PipelineFile`](crate::PipelineFile) keeps its contents between runs.
    pub pipeline_cache: Option<wgpu::PipelineCache>,
}

/// One setter per field.
impl Options {
    /// Sets [`precision`](Self::precision).
    #[must_use]
    pub fn precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// Sets [`memory_bytes`](Self::memory_bytes).
    #[must_use]
    pub fn memory_bytes(self, memory_bytes: u64) -> Self {
        Self { memory_bytes, ..self }
    }

    /// Sets [`tile`](Self::tile).
    #[must_use]
    pub fn tile(self, tile: impl Into<Option<u32>>) -> Self {
        Self { tile: tile.into(), ..self }
    }

    /// Sets [`timeout`](Self::timeout).
    #[must_use]
    pub fn timeout(self, timeout: impl Into<Option<Duration>>) -> Self {
        Self { timeout: timeout.into(), ..self }
    }

    /// Sets [`kernels`](Self::kernels).
    #[must_use]
    pub fn kernels(self, kernels: KernelSet) -> Self {
        Self { kernels, ..self }
    }

    /// Sets [`skip_clean`](Self::skip_clean).
    #[must_use]
    pub fn skip_clean(self, skip_clean: bool) -> Self {
        Self { skip_clean, ..self }
    }

    /// Sets [`keep_memory`](Self::keep_memory).
    #[must_use]
    pub fn keep_memory(self, keep_memory: bool) -> Self {
        Self { keep_memory, ..self }
    }

    /// Sets [`matrix`](Self::matrix).
    #[must_use]
    pub fn matrix(self, matrix: impl Into<Option<MatrixShape>>) -> Self {
        Self { matrix: matrix.into(), ..self }
    }

    /// Sets [`pipeline_cache`](Self::pipeline_cache).
    #[must_use]
    pub fn pipeline_cache(self, cache: impl Into<Option<wgpu::PipelineCache>>) -> Self {
        Self { pipeline_cache: cache.into(), ..self }
    }
}

impl Options {
    /// Resolves the kernel set: `Auto` becomes the first of `Simd`, `Matrix` and `Tiled` that
    /// `runs`, and `Matrix` becomes `Tiled` if its `test` fails.
    ///
    /// # Errors
    /// Fails if the requested set does not run on the device called `name`.
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
                return Err(Error::Unsupported(format!(
                    "the {set} kernels do not run on {name}; they need {}; choose Auto",
                    set.needs()
                )));
            }
        };
        let failure = match kernels {
            KernelSet::Matrix(shape) => test(shape).err(),
            _ => None,
        };
        let notice =
            |error| format!("the matrix kernels fail on {name}, using Tiled instead: {error}");
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
            keep_memory: true,
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
            let failure = || Error::WrongResult("2 of 3 results are wrong".into());
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
        for (kernels, word) in [
            (KernelSet::Simd, "SUBGROUP"),
            (KernelSet::Half, "SHADER_F16"),
            (MATRIX, "subgroups of its one size"),
        ] {
            let error = choose(kernels, &[KernelSet::Tiled], true).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("GPU 7"), "{error}");
        }
    }
}
