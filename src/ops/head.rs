//! The end of the network in one kernel: 1×1 convolution, optional sigmoid, and [`output_process`].
//! Clean blocks receive the input, with its bad pixels filled.
//!
//! [`output_process`]: mod@super::output_process

use super::activity::Activity;
use super::channel_map::ChannelMap;
use super::convolution::PackedWeights;
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

/// The overrides of every variant, and of every variant of [`conv_head`](mod@super::conv_head).
pub const OVERRIDES: &[&str] = &["brightest", "sigmoid", "transfer_function"];

/// The bindings of both variants, and the first ones of [`conv_head`](mod@super::conv_head).
#[must_use]
pub fn bindings(color: ImageFormat, output: ImageFormat) -> Vec<Binding> {
    let mut bindings = result_bindings(color, output);
    bindings.extend([Binding::Buffer, Binding::TensorIn, Binding::WeightTexture]);
    bindings
}

/// A kernel name that includes the formats.
#[must_use]
pub fn name(kernel: &str, color: ImageFormat, output: ImageFormat) -> String {
    format!("{kernel} {} {}", color.source_name(), output.target_name())
}

/// The generated variant for CPU drivers.
#[must_use]
pub fn simd_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let spec = simd::spec(simd::SimdKernel::Head, 1, bindings(color, output).into(), OVERRIDES);
    let name = name(&spec.name, color, output).into();
    KernelSpec { name, features: result_features(color, output).into(), ..spec }
}

/// An operator's kernel, which depends on the image formats.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeadKernel {
    /// The kernel for noisy color and result in these formats; the number is `quads`.
    pub(super) spec: fn(usize, ImageFormat, ImageFormat) -> KernelSpec,
    /// Output quads of the 3×3 convolution.
    pub(super) quads: usize,
    /// Pixels per workgroup along x and y.
    pub(super) tile: [u32; 2],
}

impl HeadKernel {
    /// The kernel of a head on its own.
    fn alone(kernels: KernelSet) -> Self {
        match kernels {
            KernelSet::Simd => {
                let tile = simd::SimdKernel::Head.tile();
                Self { spec: |_, color, output| simd_spec(color, output), quads: 0, tile }
            }
            _ => Self { spec: |_, color, output| spec(color, output), quads: 0, tile: [8, 8] },
        }
    }
}

/// The operator, alone or with the preceding 3×3 convolution: see [`conv_head`].
///
/// [`conv_head`]: mod@super::conv_head
#[derive(Debug)]
pub struct Head {
    pub(super) kernel: HeadKernel,
    /// The output of [`pack`].
    pub(super) weights: wgpu::TextureView,
    /// Bias and weights of the 3×3 convolution.
    pub(super) conv: Option<(wgpu::Buffer, PackedWeights)>,
    /// Multiply-accumulates per pixel.
    pub(super) macs: usize,
    /// Whether a sigmoid follows the 1×1 convolution: `true` unless changed.
    pub sigmoid: bool,
}

/// The weights `[output][input]` and the bias in the layout that all variants read. `map` describes
/// how the input is stored.
pub(super) fn pack(context: &Context, params: &Params, map: &ChannelMap) -> wgpu::TextureView {
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
        let kernel = HeadKernel::alone(kernels.resolve(&context.device));
        let weights = pack(context, params, map);
        Self { kernel, weights, conv: None, macs: params.weight.len(), sigmoid: true }
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
        if let Some((bias, weights)) = &self.conv {
            resources.extend([bias.as_entire_binding(), weights.resource()]);
        }
        let spec =
            (self.kernel.spec)(self.kernel.quads, images.color.format(), images.output.format());
        let mut constants = images.encoding.constants().to_vec();
        constants.push(("sigmoid", f64::from(u8::from(self.sigmoid))));
        let kernel = context.kernel(&spec, &constants);
        let [x, y] = self.kernel.tile;
        let workgroups = [input.width.div_ceil(x), input.height.div_ceil(y), 1];
        kernel.dispatch_workgroups(kernel.bind(&context.device, &resources), workgroups)
    }
}
