//! The end of the network in one kernel: 1×1 convolution, sigmoid and [`output_process`], and
//! for clean blocks the input as it was.
//!
//! [`output_process`]: mod@super::output_process

use super::activity::Activity;
use super::image::{BLEND, ImageFormat};
use super::input_process::{TILE, tile_binding};
use super::output_process::Images;
use super::{ChannelMap, GpuTensor, simd};
use crate::kernel::{Binding, Context, Dispatch, Kernel, KernelSpec};
use crate::model::Params;
use crate::options::KernelSet;

/// The variant for GPUs, for a noisy colour and a result in these formats.
#[must_use]
pub fn spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    KernelSpec {
        name: name("head", color, output).into(),
        source: (color.result(output, 5) + SOURCE).into(),
        entry: "main",
        bindings: bindings(color, output).into(),
        overrides: &[],
        workgroup: [8, 8, 1],
    }
}

/// What both variants bind.
#[must_use]
pub fn bindings(color: ImageFormat, output: ImageFormat) -> Vec<Binding> {
    let (input, weights) = (Binding::TensorIn, Binding::WeightTexture);
    let (color, output) = (color.source_binding(), output.target_binding());
    vec![TILE, input, weights, Binding::Buffer, Binding::Buffer, color, output, BLEND]
}

/// Kernels for other formats have other names.
#[must_use]
pub fn name(kernel: &str, color: ImageFormat, output: ImageFormat) -> String {
    format!("{kernel} {} {}", color.source_name(), output.target_name())
}

const SOURCE: &str = include_str!("../../shaders/head.wgsl");

/// The shader without its entry point, for the variant with another one.
///
/// # Panics
/// Never: the shader has an entry point.
#[must_use]
pub fn declarations(color: ImageFormat, output: ImageFormat) -> String {
    let (text, _) = SOURCE.split_once("@compute").expect("the shader has an entry point");
    color.result(output, 5) + text
}

/// The operator.
#[derive(Debug)]
pub struct Head {
    kernels: KernelSet,
    weights: wgpu::TextureView,
}

impl Head {
    /// The operator for the 1×1 convolution's weights `[3][input]` and bias.
    #[must_use]
    pub fn new(context: &Context, kernels: KernelSet, params: &Params, map: &ChannelMap) -> Self {
        let (shape, outputs) = (simd::Shape::Head, params.bias.len());
        let inputs = params.weight.len() / outputs;
        let quads = map.len() / 4;
        let weight = |step: usize, _: usize, channel: usize, output: usize| {
            if step == quads {
                return params.bias[output];
            }
            map[step * 4 + channel].map_or(0.0, |input| params.weight[output * inputs + input])
        };
        let weights = simd::pack(context, shape, outputs, quads + 1, weight);
        Self { kernels: kernels.resolve(&context.device), weights }
    }

    /// The call that stores what `input` comes to; choose the tile with
    /// [`Dispatch::record_at`].
    #[must_use]
    pub fn dispatch(
        &self,
        context: &Context,
        input: &GpuTensor,
        activity: &Activity,
        images: &Images<'_>,
    ) -> Dispatch {
        let resources = [
            tile_binding(images.tiles),
            input.resource(),
            wgpu::BindingResource::TextureView(&self.weights),
            images.input_scale.as_entire_binding(),
            activity.clean.as_entire_binding(),
            images.color.resource(),
            images.output.resource(),
            images.blend.as_entire_binding(),
        ];
        let (kernel, pixels) = self.kernel(context, images.color.format(), images.output.format());
        let group = kernel.bind(&context.device, &resources);
        kernel.dispatch(group, [input.width.div_ceil(pixels), input.height, 1])
    }

    /// The kernel for these formats, and the pixels that one invocation makes.
    fn kernel(&self, context: &Context, color: ImageFormat, output: ImageFormat) -> (Kernel, u32) {
        match self.kernels {
            KernelSet::Simd => {
                (context.kernel(&simd::head_spec(color, output), &[]), simd::Shape::Head.pixels())
            }
            _ => (context.kernel(&spec(color, output), &[]), 1),
        }
    }
}
