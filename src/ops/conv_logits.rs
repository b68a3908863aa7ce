//! The last 3×3 convolution of a kernel pyramid with bias and ReLU, and the 1×1 convolution to its
//! logits, in one kernel. An invocation holds all channels of its pixels, so no features are
//! stored.
//!
//! Values kept in registers are not rounded to the tensors' 16 bits.

use std::borrow::Cow;

use super::channel_map::ChannelMap;
use super::convolution::{Convolution, PackedWeights, Tiling, Variant};
use super::matrix::{self, MatrixKernel};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table, storage_buffer, weight_texture};
use super::tiled_weights::tiled_weights;
use super::{conv3x3, need, simd};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::model::Params;

/// The most channels of the 3×3 convolution that an invocation holds.
pub const CHANNELS: usize = 16;

const fn bindings(weights: Binding) -> [Binding; 8] {
    let [input, output] = [Binding::TensorIn, Binding::TensorOut];
    let (bias, map) = (Binding::Buffer, Binding::ActivityIn);
    [input, output, weights, bias, map, need::UNIFORM, weights, bias]
}

/// The variant for GPUs.
#[must_use]
pub fn tiled_spec(tiling: Tiling) -> KernelSpec {
    let overrides = &["largest", "relu"];
    tiling.spec("conv_logits", "conv_logits_tiled", vec![], &BINDINGS[..], overrides)
}

const BINDINGS: [Binding; 8] = bindings(Binding::Buffer);
const SIMD_BINDINGS: [Binding; 8] = bindings(Binding::WeightTexture);

/// The generated variant for CPU drivers, for this many quads of the 3×3 convolution.
#[must_use]
pub fn simd_spec(quads: usize) -> KernelSpec {
    let bindings = Cow::Borrowed(&SIMD_BINDINGS[..]);
    simd::spec(simd::SimdKernel::ConvLogits, quads, bindings, &["largest", "relu"])
}

/// The variant for GPUs with matrix units. Its 1×1 convolution, a twelfth of the products, runs
/// without them, in 32-bit floats.
#[must_use]
pub fn matrix_spec(shape: MatrixShape) -> KernelSpec {
    matrix::spec(MatrixKernel::ConvLogits, shape, CHANNELS as u32, &BINDINGS[..])
}

/// The operator. `params` hold the 3×3 convolution's weights, `[channel][channel][3][3]`, followed
/// by the 1×1 convolution's, `[logit][channel]`; biases likewise. The input is stored as in `map`.
///
/// # Panics
/// Panics if there are more than 16 channels.
#[must_use]
pub fn conv_logits(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    map: &ChannelMap,
) -> Convolution {
    let channels = map.iter().flatten().count();
    assert!(channels <= CHANNELS, "{channels} channels, but an invocation holds {CHANNELS}");
    let (conv, logits) = params.weight.split_at(9 * channels * channels);
    let (bias, logits_bias) = params.bias.split_at(channels);
    let weight = |o: usize, i: usize, tap: usize| conv[(o * channels + i) * 9 + tap];
    let taps = Taps { outputs: channels, taps: 9, map, weight: &weight };
    let (variant, logits) = match kernels.resolve(&context.device) {
        KernelSet::Simd => generated(context, &taps, logits),
        KernelSet::Matrix(shape) => {
            let variant = matrix::variant(context, matrix_spec(shape), shape, &[&taps]);
            (variant, logits_buffer(context, logits, channels))
        }
        tiled_set => tiled(context, Tiling::of(tiled_set), &taps, logits),
    };
    // `relu` is that of the logits; the inner ReLU is fixed.
    let constants = [("largest", context.precision.largest()), ("relu", 0.0)];
    let mut held = bias.to_vec();
    held.resize(CHANNELS, 0.0);
    let outputs = logits_bias.len();
    Convolution::new(context, variant, bias_table(context, &held, CHANNELS), &constants)
        .followed_by(logits, bias_table(context, logits_bias, outputs))
}

fn tiled(
    context: &Context,
    tiling: Tiling,
    taps: &Taps<'_>,
    logits: &[f32],
) -> (Variant, PackedWeights) {
    let weights = tiled_weights(context, tiling, &[taps]);
    let variant = Variant::tiled(tiled_spec(tiling), tiling, weights, 1);
    (variant, logits_buffer(context, logits, taps.outputs))
}

fn logits_buffer(context: &Context, logits: &[f32], channels: usize) -> PackedWeights {
    PackedWeights::Buffer(storage_buffer(context, "logits", &matrices(logits, channels)))
}

fn generated(context: &Context, taps: &Taps<'_>, logits: &[f32]) -> (Variant, PackedWeights) {
    let shape = simd::SimdKernel::ConvLogits;
    let weights = conv3x3::generated_weights(context, shape, taps);
    let variant = Variant::simd(simd_spec(shape.quads(taps.outputs)), shape, weights, taps.outputs);
    let quads = CHANNELS as u32 / 4;
    let matrices = matrices(logits, taps.outputs);
    let size = [4, quads, matrices.len() as u32 / (16 * quads)];
    (variant, PackedWeights::Texture(weight_texture(context, size, &matrices)))
}

/// `[quad of logits][quad of channels]` matrices, column by column: column j holds what channel j
/// adds to four logits.
fn matrices(logits: &[f32], channels: usize) -> Vec<f32> {
    let outputs = logits.len() / channels;
    let held = (0..CHANNELS).map(|c| (c < channels).then_some(c)).collect();
    let weight = |o: usize, i: usize, _: usize| logits[o * channels + i];
    Taps { outputs, taps: 1, map: &held, weight: &weight }.tiled(outputs.div_ceil(4), 1)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Convolution {
    conv_logits(layer.context, layer.kernels, layer.params, layer.maps[0])
}
