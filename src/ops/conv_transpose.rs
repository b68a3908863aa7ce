//! Transposed convolution, 2×2 kernel, stride 2, plus bias: doubles both sides.

use super::channel_map::ChannelMap;
use super::convolution::{Convolution, Variant, plain_spec};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table};
use crate::gpu::kernel::{Context, KernelSpec};
use crate::model::Params;

/// The kernel.
pub const PLAIN: KernelSpec = plain_spec("conv_transpose", &["largest"]);

/// The operator; weights are `[input][output][ky][kx]`, as PyTorch stores them.
#[must_use]
pub fn conv_transpose(context: &Context, params: &Params, map: &ChannelMap) -> Convolution {
    let outputs = params.bias.len();
    let weight = |o: usize, i: usize, tap: usize| params.weight[(i * outputs + o) * 4 + tap];
    let taps = Taps { outputs, taps: 4, map, weight: &weight };
    let variant = Variant::plain(context, PLAIN, &taps);
    let bias = bias_table(context, &params.bias, outputs);
    Convolution::new(context, variant, bias, &[("largest", context.precision.largest())])
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Convolution {
    conv_transpose(layer.context, layer.params, layer.maps[0])
}
