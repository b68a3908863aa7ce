//! 1×1 convolution plus bias: a matrix per pixel.

use super::convolution::{Convolution, Variant, spec};
use super::packing::Taps;
use super::{ChannelMap, simd};
use crate::kernel::{Context, KernelSpec};
use crate::model::Params;
use crate::options::KernelSet;

/// The readable definition, and the variant for GPUs.
pub const PLAIN: KernelSpec =
    spec("conv1x1", include_str!("../../shaders/conv1x1.wgsl"), &["largest"]);

/// The operator; weights are `[output][input]`.
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
    let variant = match kernels.resolve(&context.device) {
        KernelSet::Simd => Variant::simd(context, simd::Shape::Conv1x1, &taps),
        _ => Variant::plain(context, PLAIN, &taps),
    };
    Convolution::new(context, variant, &params.bias, &[("largest", context.precision.largest())])
}
