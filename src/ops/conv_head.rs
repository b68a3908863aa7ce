//! The last 3×3 convolution with bias and ReLU, and [`head`](mod@super::head) after it, in one
//! kernel: an invocation holds all channels of its pixels, so nothing is stored in between.
//!
//! Values kept in registers are not rounded to the tensors' 16 bits.

use super::channel_map::ChannelMap;
use super::convolution::TILE;
use super::head::{self, Head, HeadKernel};
use super::image::{ImageFormat, result_features};
use super::packing::{Taps, storage_buffer};
use super::{conv3x3, simd};
use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::model::{Network, Op, Params};
use crate::shader::ShaderRoot;

/// The most channels of the 3×3 convolution that an invocation holds.
const CHANNELS: usize = 16;

/// The bindings of both variants.
#[must_use]
pub fn bindings(color: ImageFormat, output: ImageFormat, weights: Binding) -> Vec<Binding> {
    let mut bindings = head::bindings(color, output);
    bindings.extend([Binding::Buffer, weights]);
    bindings
}

/// The variant for GPUs, for noisy color and result in these formats.
#[must_use]
pub fn tiled_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    KernelSpec {
        name: head::name("conv_head_tiled", color, output).into(),
        source: ShaderRoot::Module("conv_head_tiled"),
        features: features(color, output).into(),
        entry: "main",
        bindings: bindings(color, output, Binding::Buffer).into(),
        overrides: head::OVERRIDES,
        workgroup: [8, 8, 1],
    }
}

/// The generated variant for CPU drivers, for this many output quads of the 3×3 convolution.
#[must_use]
pub fn simd_spec(quads: usize, color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let bindings = bindings(color, output, Binding::WeightTexture).into();
    let spec = simd::spec(simd::SimdKernel::ConvHead, quads, bindings, head::OVERRIDES);
    let name = head::name(&spec.name, color, output).into();
    KernelSpec { name, features: features(color, output).into(), ..spec }
}

/// The features of both variants.
fn features(color: ImageFormat, output: ImageFormat) -> Vec<&'static str> {
    let mut features = result_features(color, output);
    features.push("conv_head");
    features
}

/// Whether the kernel can be the end of a network whose last tensor the head reads.
///
/// It does not replace matrix kernels: they compute the convolution in a fraction of the tiled
/// kernel's time, and the tensor in between costs less than the difference.
#[must_use]
pub fn ends(network: &Network, kernels: KernelSet) -> bool {
    let last = network.layers.last().is_some_and(|layer| layer.op == Op::Conv3x3 { relu: true });
    let fits = network.shapes[network.output()].channels <= CHANNELS;
    last && fits && !matches!(kernels, KernelSet::Matrix(_))
}

/// The operator for the 3×3 convolution's weights, `[output][input][ky][kx]`, whose input is stored
/// as in `map`, and the 1×1 convolution's, `[3][output]`.
///
/// # Panics
/// Panics if the 3×3 convolution has more than 16 outputs.
#[must_use]
pub fn conv_head(
    context: &Context,
    kernels: KernelSet,
    [conv, head]: [&Params; 2],
    map: &ChannelMap,
) -> Head {
    let outputs = conv.bias.len();
    assert!(outputs <= CHANNELS, "{outputs} channels, but an invocation holds {CHANNELS}");
    let inputs = conv.weight.len() / (9 * outputs);
    let weight = |o: usize, i: usize, tap: usize| conv.weight[(o * inputs + i) * 9 + tap];
    let taps = Taps { outputs, taps: 9, map, weight: &weight };
    let shape = simd::SimdKernel::ConvHead;
    let kernels = kernels.resolve(&context.device);
    let (kernel, weights) = if kernels == KernelSet::Simd {
        let (quads, tile) = (shape.quads(outputs), shape.tile());
        let weights = conv3x3::generated_weights(context, shape, &taps);
        (HeadKernel { spec: simd_spec, quads, tile }, weights)
    } else {
        let spec = |_, color, output| tiled_spec(color, output);
        let weights = conv3x3::tiled_weights(context, &taps);
        (HeadKernel { spec, quads: CHANNELS / 4, tile: [TILE; 2] }, weights)
    };
    Head {
        kernel,
        weights: head::pack(context, head, &held(outputs)),
        conv: Some((bias(context, conv), weights)),
        macs: conv.weight.len() + head.weight.len(),
        sigmoid: true,
    }
}

/// The channels an invocation holds. The tiled variant always computes all 16, even unused ones.
fn held(outputs: usize) -> ChannelMap {
    (0..CHANNELS).map(|c| (c < outputs).then_some(c)).collect()
}

fn bias(context: &Context, conv: &Params) -> wgpu::Buffer {
    let mut bias = conv.bias.clone();
    bias.resize(CHANNELS, 0.0);
    storage_buffer(context, "bias", &bias)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::matrix_shape::{Factor, MatrixShape};

    #[test]
    fn it_ends_networks_whose_last_convolution_an_invocation_can_hold() {
        let network = |width: usize| Network::unet(3, &[width, 40]).first(9);
        assert!(ends(&network(16), KernelSet::Simd) && ends(&network(1), KernelSet::Tiled));
        assert!(!ends(&network(17), KernelSet::Simd));
        let shape = MatrixShape { side: 16, factor: Factor::F16, lanes: 32 };
        assert!(!ends(&network(16), KernelSet::Matrix(shape)));
        let mut linear = network(16);
        linear.layers[8].op = Op::Conv3x3 { relu: false };
        assert!(!ends(&linear, KernelSet::Simd));
    }
}
