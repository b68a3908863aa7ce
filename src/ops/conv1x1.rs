//! 1×1 convolution plus bias: a matrix per pixel.

use super::channel_map::ChannelMap;
use super::convolution::{Convolution, Variant, plain_spec};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table};
use crate::gpu::kernel::{Context, KernelSpec};
use crate::model::Params;

/// The kernel.
pub const PLAIN: KernelSpec = plain_spec("conv1x1", &["largest"]);

/// The operator; weights are `[output][input]`.
#[must_use]
pub fn conv1x1(context: &Context, params: &Params, map: &ChannelMap) -> Convolution {
    let outputs = params.bias.len();
    let inputs = params.weight.len() / outputs;
    let weight = |o: usize, i: usize, _tap: usize| params.weight[o * inputs + i];
    let taps = Taps { outputs, taps: 1, map, weight: &weight };
    let variant = Variant::plain(context, PLAIN, &taps);
    let bias = bias_table(context, &params.bias, outputs);
    Convolution::new(context, variant, bias, &[("largest", context.precision.largest())])
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Convolution {
    conv1x1(layer.context, layer.params, layer.maps[0])
}
