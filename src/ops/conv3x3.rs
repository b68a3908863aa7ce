//! 3×3 convolution with zero padding of 1, bias (with batch norm folded in) and ReLU.

use super::channel_map::ChannelMap;
use super::convolution::{Convolution, PackedWeights, TILED_QUADS, Tiling, Variant, plain_spec};
use super::matrix::{self, MatrixKernel};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table};
use super::tiled_weights::tiled_weights;
use super::{need, simd};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::model::{Op, Params};
use std::borrow::Cow;

/// The readable definition.
pub const PLAIN: KernelSpec = plain_spec("conv3x3", &["largest", "relu"]);

/// The variant for GPUs. `pools` adds the max-pool that follows.
#[must_use]
pub fn tiled_spec(tiling: Tiling, pools: bool) -> KernelSpec {
    let name = if pools { "conv3x3_pool" } else { "conv3x3" };
    let features = if pools { vec!["pools"] } else { vec![] };
    let bindings = if pools { &TILED_POOL[..] } else { &TILED };
    tiling.spec(name, "conv3x3_tiled", features, bindings, &["largest", "relu"])
}

/// The bindings of the generated variant.
pub(super) const SIMD_BINDINGS: [Binding; 6] = bindings(Binding::WeightTexture);

const TILED: [Binding; 6] = bindings(Binding::Buffer);
const TILED_POOL: [Binding; 7] = {
    let [input, output, weights, bias, activity, need] = TILED;
    [input, output, weights, bias, activity, need, Binding::TensorOut]
};

const fn bindings(weights: Binding) -> [Binding; 6] {
    let (input, output) = (Binding::TensorIn, Binding::TensorOut);
    [input, output, weights, Binding::Buffer, Binding::ActivityIn, need::UNIFORM]
}

/// The generated variant for CPU drivers, with this many output quads per invocation.
#[must_use]
pub fn simd_spec(out_quads: usize) -> KernelSpec {
    let bindings = Cow::Borrowed(&SIMD_BINDINGS[..]);
    simd::spec(simd::SimdKernel::Conv3x3, out_quads, bindings, &["largest", "relu"])
}

/// The variant for GPUs with matrix units, with this many output channels per workgroup.
#[must_use]
pub fn matrix_spec(shape: MatrixShape, channels: u32, pools: bool) -> KernelSpec {
    let bindings = if pools { &TILED_POOL[..] } else { &TILED };
    matrix::spec(MatrixKernel::Conv3x3 { pools }, shape, channels, bindings)
}

/// The operator. Weights are `[output][input][ky][kx]`. With `pools`, it also computes the max-pool
/// of its output if the variant can; see [`Operator::pools`](super::operator::Operator::pools).
#[must_use]
pub fn conv3x3(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    map: &ChannelMap,
    relu: bool,
    pools: bool,
) -> Convolution {
    let outputs = params.bias.len();
    let inputs = params.weight.len() / (9 * outputs);
    let weight = |o: usize, i: usize, tap: usize| params.weight[(o * inputs + i) * 9 + tap];
    let taps = Taps { outputs, taps: 9, map, weight: &weight };
    let variant = match kernels.resolve(&context.device) {
        KernelSet::Simd => generated(context, &taps),
        KernelSet::Matrix(shape) => multiplied(context, shape, &taps, pools),
        KernelSet::Plain => Variant::plain(context, PLAIN, &taps),
        tiled_set => tiled(context, Tiling::of(tiled_set), &taps, pools),
    };
    let relu = f64::from(u8::from(relu));
    let constants = [("largest", context.precision.largest()), ("relu", relu)];
    let bias = bias_table(context, &params.bias, outputs);
    Convolution::new(context, variant, bias, &constants)
}

fn generated(context: &Context, taps: &Taps<'_>) -> Variant {
    let shape = simd::SimdKernel::Conv3x3;
    let spec = simd_spec(shape.quads(taps.outputs));
    Variant::simd(spec, shape, generated_weights(context, shape, taps), taps.outputs)
}

/// One step is a kernel row of an input quad.
pub(super) fn generated_weights(
    context: &Context,
    shape: simd::SimdKernel,
    taps: &Taps<'_>,
) -> PackedWeights {
    let in_quads = taps.in_quads();
    let weight = |step: usize, column: usize, channel: usize, output: usize| {
        taps.at(output, step % in_quads * 4 + channel, step / in_quads * 3 + column)
    };
    PackedWeights::Texture(simd::pack(context, shape, taps.outputs, 3 * in_quads, weight))
}

fn tiled(context: &Context, tiling: Tiling, taps: &Taps<'_>, pools: bool) -> Variant {
    let blocks = taps.out_quads().div_ceil(TILED_QUADS);
    let (spec, weights) = (tiled_spec(tiling, pools), tiled_weights(context, tiling, &[taps]));
    Variant { pools, ..Variant::tiled(spec, tiling, weights, blocks) }
}

fn multiplied(context: &Context, shape: MatrixShape, taps: &Taps<'_>, pools: bool) -> Variant {
    let spec = matrix_spec(shape, matrix::channels_per_workgroup(taps.outputs), pools);
    Variant { pools, ..matrix::variant(context, spec, shape, &[taps]) }
}

/// The operator of a layer, including the max-pool that follows if the variant can.
pub(super) fn operator(layer: &LayerRequest<'_>, relu: bool) -> Convolution {
    let pools = layer.next == Some(Op::MaxPool);
    conv3x3(layer.context, layer.kernels, layer.params, layer.maps[0], relu, pools)
}
