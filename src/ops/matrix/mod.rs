//! Generated convolutions for matrix units (wgpu's cooperative matrices): 3×3, with or without the
//! max-pool that follows, the first one with the images' encoding, the start of a decoder level,
//! and the last one with its logits.
//!
//! A convolution is a sum, over taps and input channels, of matrix products: pixels × input
//! channels by input channels × output channels. A subgroup multiplies square tiles of these with
//! one instruction. WGSL fixes their size and type in the text, so this module writes the text, for
//! tiles of 16×16 (NVIDIA) and 8×8 (lavapipe). Adapters whose subgroups come in several sizes, as
//! wgpu reports for AMD and Apple, run the tiled kernels.
//!
//! A workgroup of four subgroups computes eight rows of pixels, two tiles wide, with 16 or 32
//! output channels; the sums of more would not fit in registers. Between two barriers, it stages a
//! slice of as many input channels as a tile is wide in workgroup memory, with the pixels' border.
//! The tiles of pixels are rows of it, shifted by the tap. Weights come straight from their buffer.
//! Sums are 32-bit floats.
//!
//! A tile holds pixels of even columns or of odd ones, and a subgroup computes two rows, so it has
//! four sums for each square of 2×2 pixels. A max-pool is their maximum. In an upsampled tensor,
//! each of the four has the parity that selects its taps.
//!
//! A tile's elements have no addresses, so sums also pass through workgroup memory, for bias, clamp
//! and store. Workgroup memory takes at most 14976 of the 16384 bytes that every device has.
//!
//! No GPU has timed these kernels yet: tile and workgroup sizes are reasoned, not measured.

mod wgsl;

use std::borrow::Cow;

use super::convolution::{PackedWeights, Variant};
use super::packing::{Taps, storage_buffer};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::matrix_shape::{Factor, MatrixShape, SUBGROUPS};
use crate::shader::ShaderRoot;

/// Sums of a subgroup in flight to the output at a time.
pub const SUMS: u32 = 256;

/// What a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixKernel {
    /// The 3×3 convolution.
    Conv3x3 {
        /// Whether it also stores the max-pool of its output.
        pools: bool,
    },
    /// The first 3×3 convolution, which encodes the images itself.
    InputConv,
    /// The start of a decoder level.
    UpConv,
    /// The last 3×3 convolution of a kernel pyramid and the 1×1 convolution to its logits.
    ConvLogits,
}

impl MatrixKernel {
    fn name(self) -> &'static str {
        match self {
            Self::Conv3x3 { pools: false } => "conv3x3_matrix",
            Self::Conv3x3 { pools: true } => "conv3x3_matrix_pool",
            Self::InputConv => "input_conv_matrix",
            Self::UpConv => "up_conv_matrix",
            Self::ConvLogits => "conv_logits_matrix",
        }
    }
}

/// Output channels per workgroup: 32 reuse pixels best, but waste work on layers of up to 16.
#[must_use]
pub fn channels_per_workgroup(outputs: usize) -> u32 {
    if outputs <= 16 { 16 } else { 32 }
}

/// The generated kernel.
#[must_use]
pub fn spec(
    kernel: MatrixKernel,
    shape: MatrixShape,
    channels: u32,
    bindings: impl Into<Cow<'static, [Binding]>>,
) -> KernelSpec {
    let MatrixShape { side, lanes, .. } = shape;
    let (name, factor) = (kernel.name(), shape.wgsl_type());
    KernelSpec {
        name: format!("{name}{side}_{factor}_{lanes}_{channels}").into(),
        source: ShaderRoot::Generated(wgsl::source(kernel, shape, channels)),
        features: features(kernel, shape, channels).into(),
        entry: "main",
        bindings: bindings.into(),
        overrides: &["largest", "relu"],
        workgroup: [lanes * SUBGROUPS, 1, 1],
    }
}

fn features(kernel: MatrixKernel, shape: MatrixShape, channels: u32) -> Vec<&'static str> {
    let factor = (shape.factor == Factor::F16).then_some("factor_f16");
    let side = (shape.side == 16).then_some("side_16");
    let channels = (channels == 32).then_some("channels_32");
    let kernel = match kernel {
        MatrixKernel::InputConv => Some("input_conv"),
        MatrixKernel::UpConv => Some("up_conv"),
        MatrixKernel::Conv3x3 { .. } | MatrixKernel::ConvLogits => None,
    };
    [factor, side, channels, kernel].into_iter().flatten().collect()
}

/// Pixels per workgroup along x and y.
pub(super) fn tile(shape: MatrixShape) -> [u32; 2] {
    [2 * shape.side, 2 * SUBGROUPS]
}

/// The variant with this kernel, which must be of this shape, and the weights of each tensor that
/// it reads.
#[must_use]
pub fn variant(
    context: &Context,
    spec: KernelSpec,
    shape: MatrixShape,
    taps: &[&Taps<'_>],
) -> Variant {
    let outputs = taps[0].outputs;
    Variant {
        spec,
        weights: pack(context, shape, taps),
        tile: tile(shape),
        blocks: (outputs as u32).div_ceil(channels_per_workgroup(outputs)),
        footprint: Some(tile(shape)[0]),
        pools: false,
    }
}

/// The weights of one tensor after another, each as
/// `[block][slice of input channels][tap][output channel][input channel]`, so that a tile of output
/// channels is a column-major matrix.
pub(super) fn pack(context: &Context, shape: MatrixShape, taps: &[&Taps<'_>]) -> PackedWeights {
    let data: Vec<f32> = taps.iter().flat_map(|taps| tiles(shape.side as usize, taps)).collect();
    PackedWeights::Buffer(match shape.factor {
        Factor::F32 => storage_buffer(context, "weights", &data),
        Factor::F16 => storage_buffer(context, "weights", &halves(&data)),
    })
}

fn tiles(side: usize, taps: &Taps<'_>) -> Vec<f32> {
    let channels = channels_per_workgroup(taps.outputs) as usize;
    let mut data = Vec::new();
    for block in 0..taps.outputs.div_ceil(channels) {
        for slice in 0..taps.map.len().div_ceil(side) {
            for (tap, o) in (0..taps.taps).flat_map(|tap| (0..channels).map(move |o| (tap, o))) {
                let output = block * channels + o;
                data.extend((0..side).map(|i| taps.at(output, slice * side + i, tap)));
            }
        }
    }
    data
}

fn halves(values: &[f32]) -> Vec<half::f16> {
    let largest = half::f16::MAX.to_f32();
    values.iter().map(|v| half::f16::from_f32(v.clamp(-largest, largest))).collect()
}
