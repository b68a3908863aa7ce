//! 3×3 convolution with zero padding of 1, bias (into which batch norm is folded), and ReLU.

use super::convolution::{Convolution, Variant, Weights, spec};
use super::packing::{Taps, storage_buffer};
use super::{ChannelMap, simd};
use crate::kernel::{Context, KernelSpec};
use crate::model::Params;
use crate::options::KernelSet;

/// The readable definition.
pub const PLAIN: KernelSpec =
    spec("conv3x3", include_str!("../../shaders/conv3x3.wgsl"), &["largest", "relu"]);

/// The variant for GPUs.
pub const TILED: KernelSpec =
    spec("conv3x3_tiled", include_str!("../../shaders/conv3x3_tiled.wgsl"), &["largest", "relu"]);

/// Output quads of one invocation of the tiled variant.
const TILED_QUADS: usize = 4;
/// Pixels per side that one invocation of the tiled variant makes.
const TILED_PIXELS: u32 = 2;

/// The operator; weights are `[output][input][ky][kx]`.
#[must_use]
pub fn conv3x3(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    map: &ChannelMap,
    relu: bool,
) -> Convolution {
    let outputs = params.bias.len();
    let inputs = params.weight.len() / (9 * outputs);
    let weight = |o: usize, i: usize, tap: usize| params.weight[(o * inputs + i) * 9 + tap];
    let taps = Taps { outputs, taps: 9, map, weight: &weight };
    let variant = match kernels.resolve(&context.device) {
        KernelSet::Simd => Variant::simd(context, simd::Shape::Conv3x3, &taps),
        KernelSet::Plain => Variant::plain(context, PLAIN, &taps),
        KernelSet::Tiled | KernelSet::Auto => tiled(context, &taps),
    };
    let relu = f64::from(u8::from(relu));
    let constants = [("largest", context.precision.largest()), ("relu", relu)];
    Convolution::new(context, variant, &params.bias, &constants)
}

/// Weights as `[block of output quads][in_quad][tap][out_quad]` matrices.
fn tiled(context: &Context, taps: &Taps<'_>) -> Variant {
    let blocks = taps.out_quads().div_ceil(TILED_QUADS);
    let mut data = Vec::new();
    for block in 0..blocks {
        for in_quad in 0..taps.in_quads() {
            for tap in 0..9 {
                for quad in 0..TILED_QUADS {
                    data.extend(taps.matrix(block * TILED_QUADS + quad, in_quad, tap));
                }
            }
        }
    }
    let weights = Weights::Buffer(storage_buffer(context, "weights", &data));
    Variant { spec: TILED, weights, grid: [TILED_PIXELS, TILED_PIXELS, blocks as u32] }
}
