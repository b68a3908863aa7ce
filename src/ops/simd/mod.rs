//! Convolutions as straight-line code for CPU drivers such as lavapipe.
//!
//! llvmpipe runs eight invocations in the lanes of one vector. A weight that every lane needs is
//! cheapest if each lane loads a different one and `subgroupBroadcast` with a constant lane shares
//! them; accumulators are cheapest as separate variables. WGSL has neither unrolling nor templates,
//! so the module `text` writes the entry points, which call functions of `shaders/`. The plain
//! kernels remain the definition, and the tests compare every generated variant with the same
//! references.
//!
//! Each invocation computes a few pixels of a row and `4 · out_quads` output channels. Reads
//! outside a tensor rely on the driver returning 0, which lavapipe does and the border cases of the
//! tests confirm; GPUs run the tiled kernels instead. Writes outside do nothing, as WGSL demands.

mod text;
mod walk;

use std::borrow::Cow;

use self::walk::Walk;
use super::packing::weight_texture;
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::kernel_set::SIMD_LANES;
use crate::shader::ShaderRoot;

/// The operator a generated kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SimdKernel {
    /// [`super::conv1x1`].
    Conv1x1,
    /// [`super::conv3x3`].
    Conv3x3,
    /// [`super::up_conv`].
    UpConv,
    /// [`super::head`].
    Head,
    /// [`super::conv_logits`].
    ConvLogits,
}

/// Invocations that share a set of weights: a subgroup.
pub const LANES: u32 = SIMD_LANES;

impl SimdKernel {
    fn name(self) -> &'static str {
        match self {
            Self::Conv1x1 => "conv1x1",
            Self::Conv3x3 => "conv3x3",
            Self::UpConv => "up_conv",
            Self::Head => "head",
            Self::ConvLogits => "conv_logits",
        }
    }

    /// Pixels of a row per invocation. More pixels need fewer broadcasts each; with half the
    /// channels, the number of accumulators stays the same.
    #[must_use]
    pub fn pixels(self) -> u32 {
        if self == Self::UpConv { 8 } else { 4 }
    }

    /// Pixels along x and y per workgroup.
    #[must_use]
    pub fn tile(self) -> [u32; 2] {
        [self.pixels() * LANES, 1]
    }

    /// Output quads per invocation for a layer: as many as the registers hold, or fewer.
    #[must_use]
    pub fn quads(self, outputs: usize) -> usize {
        let most = if self == Self::UpConv { 2 } else { 4 };
        outputs.div_ceil(4).min(most)
    }

    /// All values that [`quads`](Self::quads) can return.
    #[must_use]
    pub fn all_quads(self) -> std::ops::RangeInclusive<usize> {
        match self {
            Self::Conv1x1 | Self::Conv3x3 | Self::ConvLogits => 1..=4,
            Self::UpConv => 1..=2,
            Self::Head => 1..=1,
        }
    }

    /// Its walks over the tensors it reads.
    fn walks(self) -> &'static [Walk] {
        match self {
            Self::Conv3x3 | Self::ConvLogits => &[walk::ROWS],
            Self::UpConv => &[walk::SKIP, walk::LOW],
            Self::Conv1x1 | Self::Head => &[walk::POINT],
        }
    }
}

/// The generated kernel for this many output quads per invocation, without features.
#[must_use]
pub fn spec(
    shape: SimdKernel,
    out_quads: usize,
    bindings: Cow<'static, [Binding]>,
    overrides: &'static [&'static str],
) -> KernelSpec {
    KernelSpec {
        name: format!("{}_simd{}", shape.name(), out_quads * 4).into(),
        source: ShaderRoot::Generated(text::source(shape, out_quads)),
        features: Cow::Borrowed(&[]),
        entry: "main",
        bindings,
        overrides,
        workgroup: [LANES, 1, 1],
    }
}

/// Workgroups along z: blocks of `4 · quads` output channels.
#[must_use]
pub fn blocks(shape: SimdKernel, outputs: usize) -> usize {
    outputs.div_ceil(4 * shape.quads(outputs))
}

/// The weights in the layout of the generated kernel: layer = block, row = step (kernel row × input
/// quad, walk after walk), texel = (tap × input channel × output quad), padded to whole lanes.
/// `weight` returns the value for a step, a tap, a channel of the step's quad and an output.
#[must_use]
pub fn pack(
    context: &Context,
    shape: SimdKernel,
    outputs: usize,
    steps: usize,
    weight: impl Fn(usize, usize, usize, usize) -> f32,
) -> wgpu::TextureView {
    let (quads, blocks) = (shape.quads(outputs), blocks(shape, outputs));
    let taps = shape.walks().iter().map(|walk| walk.taps).max().unwrap_or(0);
    let width = (taps * 4 * quads).next_multiple_of(LANES as usize);
    let mut texels = vec![0.0; blocks * steps * width * 4];
    for (i, texel) in texels.chunks_exact_mut(4).enumerate() {
        let (x, step, block) = (i % width, i / width % steps, i / width / steps);
        let (tap, channel, quad) = (x / quads / 4, x / quads % 4, x % quads);
        let first = (block * quads + quad) * 4;
        for (output, value) in (first..outputs).zip(texel).filter(|_| tap < taps) {
            *value = weight(step, tap, channel, output);
        }
    }
    weight_texture(context, [width as u32, steps as u32, blocks as u32], &texels)
}
