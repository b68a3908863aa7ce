//! 3×3 convolution on matrix units (cooperative matrices of `wgpu`) as generated code.
//!
//! A convolution is a sum over taps and input channels of products of matrices: pixels × input
//! channels by input channels × output channels. A subgroup multiplies square tiles of them with
//! one instruction. WGSL fixes their size and type in the text, so this module writes it, for
//! tiles of 16×16 (NVIDIA) and 8×8 (lavapipe). Adapters whose subgroups come in several sizes,
//! as wgpu says of AMD's and Apple's, run the tiled kernels.
//!
//! A workgroup of four subgroups makes eight rows of pixels, two tiles wide, of 16 or 32 output
//! channels: sums of more would not stay in registers. For each slice of input channels, as many
//! as a tile is wide, it stages the pixels with their border in workgroup memory; the tiles of
//! pixels are rows of it, shifted by the tap. Weights come from their buffer. Sums are in 32-bit
//! float. A tile's elements have no address, so sums go through workgroup memory too, for bias,
//! clamp and store. Workgroup memory: 14976 bytes at most, of the 16384 that every device has.
//!
//! No GPU has timed these kernels yet: tile and workgroup are reasoned, not measured.

mod wgsl;

use super::convolution::{PackedWeights, Variant};
use super::packing::{Taps, storage_buffer};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::matrix_shape::{Factor, MatrixShape, SUBGROUPS};
use crate::shader::ShaderRoot;

/// Tiles side by side along the pixels of a row that one workgroup makes.
pub const COLUMNS: u32 = 2;
/// Rows of pixels that one subgroup makes.
pub const ROWS: u32 = 2;
/// Sums of a subgroup that are on their way to the output at a time.
pub const SUMS: u32 = 256;

/// Output channels of a workgroup: 32 reuse pixels best, fewer waste none.
#[must_use]
pub fn channels_per_workgroup(outputs: usize) -> u32 {
    if outputs <= 16 { 16 } else { 32 }
}

/// The generated kernel.
#[must_use]
pub fn spec(shape: MatrixShape, channels: u32) -> KernelSpec {
    let MatrixShape { side, lanes, .. } = shape;
    KernelSpec {
        name: format!("conv3x3_matrix{side}_{}_{lanes}_{channels}", shape.wgsl_type()).into(),
        source: ShaderRoot::Generated(wgsl::source(shape, channels)),
        features: features(shape, channels).into(),
        entry: "main",
        bindings: vec![Binding::TensorIn, Binding::TensorOut, Binding::Buffer, Binding::Buffer]
            .into(),
        overrides: &["largest", "relu"],
        workgroup: [lanes * SUBGROUPS, 1, 1],
    }
}

fn features(shape: MatrixShape, channels: u32) -> Vec<&'static str> {
    let factor = (shape.factor == Factor::F16).then_some("factor_f16");
    let side = (shape.side == 16).then_some("side_16");
    let channels = (channels == 32).then_some("channels_32");
    [factor, side, channels].into_iter().flatten().collect()
}

/// The kernel with its weights.
#[must_use]
pub fn variant(context: &Context, shape: MatrixShape, taps: &Taps<'_>) -> Variant {
    let channels = channels_per_workgroup(taps.outputs);
    Variant {
        spec: spec(shape, channels),
        weights: PackedWeights::Buffer(pack(context, shape, taps)),
        tile: [COLUMNS * shape.side, SUBGROUPS * ROWS],
        blocks: (taps.outputs as u32).div_ceil(channels),
        footprint: None,
        pools: false,
    }
}

/// Weights as `[block][slice of input channels][tap][output channel][input channel]`, so that
/// the tile of some output channels is a matrix by columns.
fn pack(context: &Context, shape: MatrixShape, taps: &Taps<'_>) -> wgpu::Buffer {
    let side = shape.side as usize;
    let channels = channels_per_workgroup(taps.outputs) as usize;
    let mut data = Vec::new();
    for block in 0..taps.outputs.div_ceil(channels) {
        for slice in 0..taps.map.len().div_ceil(side) {
            for (tap, o) in (0..9).flat_map(|tap| (0..channels).map(move |o| (tap, o))) {
                let output = block * channels + o;
                data.extend((0..side).map(|i| taps.at(output, slice * side + i, tap)));
            }
        }
    }
    match shape.factor {
        Factor::F32 => storage_buffer(context, "weights", &data),
        Factor::F16 => storage_buffer(context, "weights", &halves(&data)),
    }
}

fn halves(values: &[f32]) -> Vec<half::f16> {
    let largest = half::f16::MAX.to_f32();
    values.iter().map(|v| half::f16::from_f32(v.clamp(-largest, largest))).collect()
}
