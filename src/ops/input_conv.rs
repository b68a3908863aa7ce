//! [`input_process`] and the first 3×3 convolution, with bias and ReLU, in one kernel, so that the
//! network's input is never stored.
//!
//! For GPUs only: the generated kernels for CPU drivers would encode every pixel 4.5 times, which
//! costs more than the tensor in between.
//!
//! [`input_process`]: mod@super::input_process

use super::conv3x3;
use super::convolution::TILE;
use super::image::{ImageFormat, source_features};
use super::input_process::{self, Sources, resources, source_names};
use super::need::{self, Need};
use super::packing::{Taps, bias_table, storage_buffer};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::tensor::GpuTensor;
use crate::model::{Encoding, INPUT, Network, Op, Params};
use crate::shader::ShaderRoot;

/// Output channels per workgroup. With more, several workgroups would encode the same pixels.
const CHANNELS: usize = 16;

/// The kernel for color, albedo and normal in these formats.
#[must_use]
pub fn spec(formats: [ImageFormat; 3]) -> KernelSpec {
    let mut bindings = input_process::bindings(formats);
    bindings.extend([Binding::Buffer, Binding::Buffer, Binding::ActivityIn, need::UNIFORM]);
    let mut features = source_features(formats);
    features.push("input_conv");
    KernelSpec {
        name: format!("input_conv {}", source_names(formats)).into(),
        source: ShaderRoot::Module("input_conv_tiled"),
        features: features.into(),
        entry: "main",
        bindings: bindings.into(),
        overrides: &[
            "brightest",
            "has_albedo",
            "has_normal",
            "largest",
            "outlier",
            "relu",
            "transfer_function",
            "unorm_normal",
        ],
        workgroup: [8, 8, 1],
    }
}

/// Whether the kernel can be the beginning of a network. It repeats the image's edge and cannot pad
/// with zeros.
#[must_use]
pub fn begins(network: &Network, encoding: Encoding, kernels: KernelSet) -> bool {
    let first = network.layers.first().is_some_and(|l| l.op == Op::Conv3x3 { relu: true });
    let alone = network.layers.iter().filter(|l| l.inputs.contains(&INPUT)).count() == 1;
    let narrow = network.shapes[1].channels <= CHANNELS;
    kernels == KernelSet::Tiled && !encoding.zero_padding && first && alone && narrow
}

/// The operator.
#[derive(Debug)]
pub struct InputConv {
    weights: wgpu::Buffer,
    bias: wgpu::Buffer,
    macs: usize,
}

impl InputConv {
    /// The operator for the convolution's weights, `[output][input][ky][kx]`.
    ///
    /// # Panics
    /// Panics if it has more than 16 outputs.
    #[must_use]
    pub fn new(context: &Context, params: &Params) -> Self {
        let outputs = params.bias.len();
        assert!(outputs <= CHANNELS, "{outputs} channels, but a workgroup makes {CHANNELS}");
        let inputs = params.weight.len() / (9 * outputs);
        let weight = |o: usize, i: usize, tap: usize| params.weight[(o * inputs + i) * 9 + tap];
        let map = input_process::channel_map(inputs);
        let taps = Taps { outputs, taps: 9, map: &map, weight: &weight };
        let weights = storage_buffer(context, "weights", &conv3x3::tiled_matrices(&taps));
        let bias = bias_table(context, &params.bias, outputs);
        Self { weights, bias, macs: params.weight.len() }
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
        let spec = spec(sources.images().map(|image| image.format()));
        let mut constants = sources.input_constants().to_vec();
        constants.extend([("largest", context.precision.largest()), ("relu", 1.0)]);
        let kernel = context.kernel(&spec, &constants);
        let uniform = need.buffer(&context.device, TILE);
        let mut resources = resources(sources, output);
        let buffers = [&self.weights, &self.bias].map(wgpu::Buffer::as_entire_binding);
        resources.extend(buffers);
        resources.push(wgpu::BindingResource::TextureView(need.map));
        resources.push(uniform.as_entire_binding());
        let group = kernel.bind(&context.device, &resources);
        kernel.dispatch_workgroups(group, [output.width, output.height, 1].map(tiles))
    }
}

fn tiles(side: u32) -> u32 {
    side.div_ceil(TILE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_begins_networks_of_the_tiled_kernels_whose_first_convolution_a_workgroup_can_make() {
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
