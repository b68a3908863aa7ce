//! The start of a decoder level in one kernel: transposed convolution of the low-resolution tensor,
//! concatenation after the skip, 3×3 convolution, bias and ReLU.
//!
//! Nothing non-linear lies between the two convolutions, so they fold into one. Some of the 3×3
//! upsampled pixels around an output pixel share a low-resolution pixel, which leaves a 2×2
//! convolution whose weights depend on the parity of the output's row and column: 4 products per
//! low-resolution channel and output, and no intermediate tensor. The transposed convolution's bias
//! passes through the 3×3 taps too, except where they see the zero padding, so each of the 3×3
//! positions relative to the border has its own bias.

mod fold;

use std::borrow::Cow;

use self::fold::Folded;
use super::channel_map::ChannelMap;
use super::convolution::{Convolution, PackedWeights, TILED_QUADS, Tiling, Variant};
use super::matrix::{self, MatrixKernel};
use super::operator::LayerRequest;
use super::packing::{Taps, bias_table};
use super::tiled_weights::tiled_weights;
use super::{need, simd};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::model::Params;

/// The bindings of the generated variant.
const SIMD_BINDINGS: [Binding; 7] = bindings(Binding::WeightTexture);

/// The variant for GPUs.
#[must_use]
pub fn tiled_spec(tiling: Tiling) -> KernelSpec {
    let (features, overrides) = (vec!["up_conv"], &["largest", "relu"]);
    tiling.spec("up_conv", "up_conv_tiled", features, &BINDINGS[..], overrides)
}

const BINDINGS: [Binding; 7] = bindings(Binding::Buffer);

const fn bindings(weights: Binding) -> [Binding; 7] {
    let [skip, low, output] = [Binding::TensorIn, Binding::TensorIn, Binding::TensorOut];
    [skip, output, weights, Binding::Buffer, Binding::ActivityIn, need::UNIFORM, low]
}

/// The generated variant for CPU drivers, with this many output quads per invocation.
#[must_use]
pub fn simd_spec(out_quads: usize) -> KernelSpec {
    let bindings = Cow::Borrowed(&SIMD_BINDINGS[..]);
    let spec = simd::spec(simd::SimdKernel::UpConv, out_quads, bindings, &["largest", "relu"]);
    KernelSpec { features: Cow::Borrowed(&["up_conv"]), ..spec }
}

/// The variant for GPUs with matrix units, with this many output channels per workgroup.
#[must_use]
pub fn matrix_spec(shape: MatrixShape, channels: u32) -> KernelSpec {
    matrix::spec(MatrixKernel::UpConv, shape, channels, &BINDINGS[..])
}

/// The operator for the skip and the low-resolution tensor, stored as in `maps`. `params` hold the
/// transposed convolution's weights to `ups` channels, `[low][up][2][2]`, followed by the 3×3
/// convolution's, `[output][skip, then up][3][3]`; biases likewise.
#[must_use]
pub fn up_conv(
    context: &Context,
    kernels: KernelSet,
    params: &Params,
    maps: [&ChannelMap; 2],
    ups: usize,
    relu: bool,
) -> Convolution {
    let [skips, lows] = maps.map(|map| map.iter().flatten().count());
    let folded = Folded::new(params, skips, lows, ups);
    let skip = |o: usize, i: usize, tap: usize| folded.skip[(o * skips + i) * 9 + tap];
    let low = |o: usize, i: usize, tap: usize| folded.low[(o * 16 + tap) * lows + i];
    let outputs = folded.outputs;
    let skip = Taps { outputs, taps: 9, map: maps[0], weight: &skip };
    let low = Taps { outputs, taps: 16, map: maps[1], weight: &low };
    let variant = match kernels.resolve(&context.device) {
        KernelSet::Simd => generated(context, &skip, &low),
        KernelSet::Matrix(shape) => {
            let spec = matrix_spec(shape, matrix::channels_per_workgroup(outputs));
            matrix::variant(context, spec, shape, &[&skip, &low])
        }
        tiled_set => tiled(context, Tiling::of(tiled_set), &skip, &low),
    };
    let constants = [("largest", context.precision.largest()), ("relu", f64::from(u8::from(relu)))];
    let bias = bias_table(context, &folded.bias, outputs);
    Convolution::new(context, variant, bias, &constants)
}

/// Rows of weights: the skip's steps, then the low-resolution tensor's for even and odd rows.
fn generated(context: &Context, skip: &Taps<'_>, low: &Taps<'_>) -> Variant {
    let (skip_quads, low_quads) = (skip.in_quads(), low.in_quads());
    let weight = |step: usize, tap: usize, channel: usize, output: usize| {
        let Some(step) = step.checked_sub(3 * skip_quads) else {
            let stored = step % skip_quads * 4 + channel;
            // The fourth tap belongs to the other steps.
            return if tap < 3 {
                skip.at(output, stored, step / skip_quads * 3 + tap)
            } else {
                0.0
            };
        };
        let (rows, stored) = (step / low_quads, step % low_quads * 4 + channel);
        let [y, row] = [rows / 2, rows % 2];
        let [x, column] = [tap / 2, tap % 2];
        low.at(output, stored, ((y * 2 + x) * 2 + row) * 2 + column)
    };
    let steps = 3 * skip_quads + 4 * low_quads;
    let (shape, outputs) = (simd::SimdKernel::UpConv, skip.outputs);
    let weights = PackedWeights::Texture(simd::pack(context, shape, outputs, steps, weight));
    Variant::simd(simd_spec(shape.quads(outputs)), shape, weights, outputs)
}

fn tiled(context: &Context, tiling: Tiling, skip: &Taps<'_>, low: &Taps<'_>) -> Variant {
    let blocks = skip.out_quads().div_ceil(TILED_QUADS);
    let weights = tiled_weights(context, tiling, &[skip, low]);
    Variant::tiled(tiled_spec(tiling), tiling, weights, blocks)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>, ups: usize, relu: bool) -> Convolution {
    let maps = [layer.maps[0], layer.maps[1]];
    up_conv(layer.context, layer.kernels, layer.params, maps, ups, relu)
}
