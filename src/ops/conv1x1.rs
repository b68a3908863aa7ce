//! 1×1 convolution plus bias: one matrix applied to every pixel.

use std::borrow::Cow;

use super::channel_map::ChannelMap;
use super::convolution::{Convolution, PackedWeights, Variant, plain_spec};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table};
use super::{conv3x3, simd};
use crate::gpu::kernel::{Context, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::model::Params;

/// The readable definition.
pub const PLAIN: KernelSpec = plain_spec("conv1x1", &["largest"]);

/// The generated variant for CPU drivers, with this many output quads per invocation.
#[must_use]
pub fn simd_spec(out_quads: usize) -> KernelSpec {
    let bindings = Cow::Borrowed(&conv3x3::SIMD_BINDINGS[..]);
    simd::spec(simd::SimdKernel::Conv1x1, out_quads, bindings, &["largest", "relu"])
}

/// The operator. Weights are `[output][input]`.
#[must_use]
pub fn conv1x1(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    map: &ChannelMap,
) -> Convolution {
    let outputs = params.bias.len();
    let inputs = params.weight.len() / outputs;
    let weight = |o: usize, i: usize, _tap: usize| params.weight[o * inputs + i];
    let taps = Taps { outputs, taps: 1, map, weight: &weight };
    let bias = bias_table(context, &params.bias, outputs);
    let largest = ("largest", context.precision.largest());
    if kernels.resolve(&context.device) == KernelSet::Simd {
        let variant = generated(context, &taps);
        return Convolution::new(context, variant, bias, &[largest, ("relu", 0.0)]);
    }
    Convolution::new(context, Variant::plain(context, PLAIN, &taps), bias, &[largest])
}

/// One step is an input quad.
fn generated(context: &Context, taps: &Taps<'_>) -> Variant {
    let shape = simd::SimdKernel::Conv1x1;
    let weight = |step: usize, _: usize, channel: usize, output: usize| {
        taps.at(output, step * 4 + channel, 0)
    };
    let weights = simd::pack(context, shape, taps.outputs, taps.in_quads(), weight);
    let spec = simd_spec(shape.quads(taps.outputs));
    Variant::simd(spec, shape, PackedWeights::Texture(weights), taps.outputs)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Convolution {
    conv1x1(layer.context, layer.kernels, layer.params, layer.maps[0])
}
