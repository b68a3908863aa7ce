//! The end of the network in one kernel: 1×1 convolution, optional sigmoid, and [`output_process`].
//! Clean blocks receive the input.
//!
//! [`output_process`]: mod@super::output_process

use super::activity::Activity;
use super::channel_map::ChannelMap;
use super::image::{ImageFormat, result_features};
use super::output_process::{ResultImages, result_bindings};
use super::simd;
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::tensor::GpuTensor;
use crate::model::Params;
use crate::shader::ShaderRoot;

/// The variant for GPUs, for noisy color and result in these formats.
#[must_use]
pub fn spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    KernelSpec {
        name: name("head", color, output).into(),
        source: ShaderRoot::Module("head"),
        features: result_features(color, output).into(),
        entry: "main",
        bindings: bindings(color, output).into(),
        overrides: OVERRIDES,
        workgroup: [8, 8, 1],
    }
}

/// The overrides of both variants.
const OVERRIDES: &[&str] = &["brightest", "sigmoid", "transfer_function"];

/// The bindings of both variants.
fn bindings(color: ImageFormat, output: ImageFormat) -> Vec<Binding> {
    let mut bindings = result_bindings(color, output);
    bindings.extend([Binding::Buffer, Binding::TensorIn, Binding::WeightTexture]);
    bindings
}

/// A kernel name that includes the formats.
#[must_use]
pub(super) fn name(kernel: &str, color: ImageFormat, output: ImageFormat) -> String {
    format!("{kernel} {} {}", color.source_name(), output.target_name())
}

/// The generated variant for CPU drivers.
#[must_use]
pub fn simd_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let spec = simd::spec(simd::SimdKernel::Head, 1, bindings(color, output).into(), OVERRIDES);
    let name = name(&spec.name, color, output).into();
    KernelSpec { name, features: result_features(color, output).into(), ..spec }
}

/// The operator.
#[derive(Debug)]
pub struct Head {
    /// The kernel for noisy color and result in these formats.
    spec: fn(ImageFormat, ImageFormat) -> KernelSpec,
    /// Pixels per workgroup along x and y.
    tile: [u32; 2],
    /// The output of [`pack`].
    weights: wgpu::TextureView,
    /// Multiply-accumulates per pixel.
    macs: usize,
    /// Whether a sigmoid follows the 1×1 convolution: `true` unless changed.
    pub sigmoid: bool,
}

/// The weights `[output][input]` and the bias in the layout that all variants read. `map` describes
/// how the input is stored.
fn pack(context: &Context, params: &Params, map: &ChannelMap) -> wgpu::TextureView {
    let outputs = params.bias.len();
    let inputs = params.weight.len() / outputs;
    let quads = map.len() / 4;
    let weight = |step: usize, _: usize, channel: usize, output: usize| {
        if step == quads {
            return params.bias[output];
        }
        map[step * 4 + channel].map_or(0.0, |input| params.weight[output * inputs + input])
    };
    simd::pack(context, simd::SimdKernel::Head, outputs, quads + 1, weight)
}

impl Head {
    /// The operator for the 1×1 convolution's weights `[3][input]` and bias.
    #[must_use]
    pub fn new(context: &Context, kernels: KernelSet, params: &Params, map: &ChannelMap) -> Self {
        let weights = pack(context, params, map);
        let macs = params.weight.len();
        let (spec, tile): (fn(_, _) -> _, _) = match kernels.resolve(&context.device) {
            KernelSet::Simd => (simd_spec, simd::SimdKernel::Head.tile()),
            _ => (spec, [8, 8]),
        };
        Self { spec, tile, weights, macs, sigmoid: true }
    }

    /// Multiply-accumulates per pixel of a tile.
    #[must_use]
    pub fn macs_per_pixel(&self) -> f64 {
        self.macs as f64
    }

    /// The call that computes and stores the result from `input`. [`Dispatch::record_at`] selects
    /// the tile.
    #[must_use]
    pub fn dispatch(
        &self,
        context: &Context,
        input: &GpuTensor,
        activity: &Activity,
        images: &ResultImages<'_>,
    ) -> Dispatch {
        let mut resources = images.resources();
        resources.extend([
            activity.clean.as_entire_binding(),
            input.resource(),
            wgpu::BindingResource::TextureView(&self.weights),
        ]);
        let spec = (self.spec)(images.color.format(), images.output.format());
        let mut constants = images.encoding.constants().to_vec();
        constants.push(("sigmoid", f64::from(u8::from(self.sigmoid))));
        let kernel = context.kernel(&spec, &constants);
        let [x, y] = self.tile;
        let workgroups = [input.width.div_ceil(x), input.height.div_ceil(y), 1];
        kernel.dispatch_workgroups(kernel.bind(&context.device, &resources), workgroups)
    }
}
