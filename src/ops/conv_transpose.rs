//! Transposed convolution, 2×2 kernel, stride 2, plus bias: doubles both sides.

use super::convolution::{Convolution, Variant, spec};
use super::packing::Taps;
use super::{ChannelMap, simd};
use crate::kernel::{Context, KernelSpec};
use crate::model::Params;
use crate::options::KernelSet;

/// The readable definition, and the variant for GPUs.
pub const PLAIN: KernelSpec =
    spec("conv_transpose", include_str!("../../shaders/conv_transpose.wgsl"), &["largest"]);

/// The operator; weights are `[input][output][ky][kx]`, as PyTorch stores them.
#[must_use]
pub fn conv_transpose(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    map: &ChannelMap,
) -> Convolution {
    let outputs = params.bias.len();
    let weight = |o: usize, i: usize, tap: usize| params.weight[(i * outputs + o) * 4 + tap];
    let taps = Taps { outputs, taps: 4, map, weight: &weight };
    let variant = match kernels.resolve(&context.device) {
        KernelSet::Simd => Variant::simd(context, simd::Shape::ConvTranspose, &taps),
        _ => Variant::plain(context, PLAIN, &taps),
    };
    Convolution::new(context, variant, &params.bias, &[("largest", context.precision.largest())])
}
