//! [`input_process`] and the first 3×3 convolution, with bias and ReLU, in one kernel, so that the
//! network's input is never stored.
//!
//! For GPUs only: the generated kernels for CPU drivers would encode every pixel 4.5 times, which
//! costs more than storing the input.
//!
//! [`input_process`]: mod@super::input_process

use super::convolution::{PackedWeights, Tiling};
use super::image::{ImageFormat, source_features};
use super::input_process::{self, Sources, resources, source_names};
use super::matrix::{self, MatrixKernel};
use super::need::{self, Need};
use super::packing::{Taps, bias_table};
use super::tiled_weights::tiled_weights;
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::MatrixShape;
use crate::gpu::tensor::GpuTensor;
use crate::model::{Encoding, INPUT, Network, Op, Params};

/// Output channels per workgroup. With more, several workgroups would encode the same pixels.
const CHANNELS: usize = 16;

/// The kernel for color, albedo and normal in these formats.
#[must_use]
pub fn tiled_spec(tiling: Tiling, formats: [ImageFormat; 3]) -> KernelSpec {
    let mut features = source_features(formats);
    features.push("input_conv");
    let spec =
        tiling.spec("input_conv", "input_conv_tiled", features, bindings(formats), OVERRIDES);
    KernelSpec { name: format!("{} {}", spec.name, source_names(formats)).into(), ..spec }
}

/// The kernel for GPUs with matrix units.
#[must_use]
pub fn matrix_spec(shape: MatrixShape, formats: [ImageFormat; 3]) -> KernelSpec {
    let bindings = bindings(formats);
    let spec = matrix::spec(MatrixKernel::InputConv, shape, CHANNELS as u32, bindings);
    let features = [source_features(formats), spec.features.into_owned()].concat();
    KernelSpec {
        name: format!("{} {}", spec.name, source_names(formats)).into(),
        features: features.into(),
        overrides: OVERRIDES,
        ..spec
    }
}

const OVERRIDES: &[&str] = &[
    "brightest",
    "has_albedo",
    "has_normal",
    "largest",
    "outlier",
    "relu",
    "transfer_function",
    "unorm_normal",
];

fn bindings(formats: [ImageFormat; 3]) -> Vec<Binding> {
    let mut bindings = input_process::bindings(formats);
    bindings.extend([Binding::Buffer, Binding::Buffer, Binding::ActivityIn, need::UNIFORM]);
    bindings
}

/// Whether a network can start with this kernel, which repeats the image's edge and cannot pad with
/// zeros.
#[must_use]
pub fn begins(network: &Network, encoding: Encoding, kernels: KernelSet) -> bool {
    let first = network.layers.first().is_some_and(|l| l.op == Op::Conv3x3 { relu: true });
    let alone = network.layers.iter().filter(|l| l.inputs.contains(&INPUT)).count() == 1;
    let narrow = network.shapes[1].channels <= CHANNELS;
    let stages = kernels.is_for_gpus();
    stages && !encoding.zero_padding && first && alone && narrow
}

/// The operator.
#[derive(Debug)]
pub struct InputConv {
    kernels: KernelSet,
    weights: PackedWeights,
    bias: wgpu::Buffer,
    macs: usize,
}

impl InputConv {
    /// The operator for the convolution's weights, `[output][input][ky][kx]`. Sets without a kernel
    /// of their own run the tiled one.
    ///
    /// # Panics
    /// Panics if it has more than 16 outputs.
    #[must_use]
    pub fn new(context: &Context, kernels: KernelSet, params: &Params) -> Self {
        let outputs = params.bias.len();
        assert!(outputs <= CHANNELS, "{outputs} channels, but a workgroup makes {CHANNELS}");
        let inputs = params.weight.len() / (9 * outputs);
        let weight = |o: usize, i: usize, tap: usize| params.weight[(o * inputs + i) * 9 + tap];
        let map = input_process::channel_map(inputs);
        let taps = Taps { outputs, taps: 9, map: &map, weight: &weight };
        let weights = match kernels {
            KernelSet::Matrix(shape) => matrix::pack(context, shape, &[&taps]),
            tiled_set => tiled_weights(context, Tiling::of(tiled_set), &[&taps]),
        };
        let bias = bias_table(context, &params.bias, outputs);
        Self { kernels, weights, bias, macs: params.weight.len() }
    }

    /// Multiply-accumulates per pixel of a tile.
    #[must_use]
    pub fn macs_per_pixel(&self) -> f64 {
        self.macs as f64
    }

    /// The call that fills `output` where it is needed. [`Dispatch::record_at`] selects the tile.
    #[must_use]
    pub fn dispatch(
        &self,
        context: &Context,
        sources: &Sources<'_>,
        output: &GpuTensor,
        need: &Need<'_>,
    ) -> Dispatch {
        let formats = sources.images().map(|image| image.format());
        let (spec, [x, y]) = match self.kernels {
            KernelSet::Matrix(shape) => (matrix_spec(shape, formats), matrix::tile(shape)),
            tiled_set => {
                let tiling = Tiling::of(tiled_set);
                (tiled_spec(tiling, formats), tiling.size())
            }
        };
        let mut constants = sources.input_constants().to_vec();
        constants.extend([("largest", context.precision.largest()), ("relu", 1.0)]);
        let kernel = context.kernel(&spec, &constants);
        let uniform = need.buffer(&context.device, x);
        let mut resources = resources(sources, output);
        resources.extend([self.weights.resource(), self.bias.as_entire_binding()]);
        resources.push(wgpu::BindingResource::TextureView(need.map));
        resources.push(uniform.as_entire_binding());
        let group = kernel.bind(&context.device, &resources);
        kernel.dispatch_workgroups(group, [output.width.div_ceil(x), output.height.div_ceil(y), 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_begins_networks_of_the_kernels_for_gpus_whose_first_convolution_a_workgroup_can_make() {
        let network = |width: usize| Network::unet(3, &[width, 40]);
        let begins = |network: &Network, kernels| begins(network, Encoding::default(), kernels);
        assert!(begins(&network(16), KernelSet::Tiled) && begins(&network(1), KernelSet::Tiled));
        assert!(!begins(&network(17), KernelSet::Tiled));
        assert!(!begins(&network(16), KernelSet::Simd) && !begins(&network(16), KernelSet::Plain));
        let mut linear = network(16);
        linear.layers[0].op = Op::Conv3x3 { relu: false };
        assert!(!begins(&linear, KernelSet::Tiled));
    }

    #[test]
    fn it_begins_no_network_whose_input_is_padded_with_zeros() {
        let zeros = Encoding { zero_padding: true, ..Encoding::default() };
        assert!(!begins(&Network::unet(3, &[16, 40]), zeros, KernelSet::Tiled));
    }
}
