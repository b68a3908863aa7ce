//! The end of the network in one kernel: 1×1 convolution, sigmoid and [`output_process`], and
//! for clean blocks the input as it was.
//!
//! [`output_process`]: mod@super::output_process

use super::activity::Activity;
use super::input_process::tile_binding;
use super::{ChannelMap, GpuTensor, simd};
use crate::kernel::{Binding, Context, Dispatch, Kernel, KernelSpec};
use crate::model::Params;
use crate::ops::tile::Tile;
use crate::options::KernelSet;

/// What both variants bind.
pub const BINDINGS: [Binding; 7] = [
    Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true },
    Binding::TensorIn,
    Binding::WeightTexture,
    Binding::Buffer,
    Binding::Buffer,
    Binding::Buffer,
    Binding::BufferMut,
];

/// The variant for GPUs.
pub const SPEC: KernelSpec = KernelSpec {
    name: std::borrow::Cow::Borrowed("head"),
    source: std::borrow::Cow::Borrowed(SOURCE),
    entry: "main",
    bindings: &BINDINGS,
    overrides: &[],
    workgroup: [8, 8, 1],
};

const SOURCE: &str = include_str!("../../shaders/head.wgsl");

/// The shader without its entry point, for the variant with another one.
///
/// # Panics
/// Never: the shader has an entry point.
#[must_use]
pub fn declarations() -> &'static str {
    SOURCE.split_once("@compute").expect("the shader has an entry point").0
}

/// The operator.
#[derive(Debug)]
pub struct Head {
    kernel: Kernel,
    weights: wgpu::TextureView,
    pixels: u32,
}

/// What the kernel reads and writes beside the tensor.
pub struct Images<'a> {
    /// [`Tile`]s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// The 32-bit float that colour was multiplied by.
    pub input_scale: &'a wgpu::Buffer,
    /// The noisy colour, 32-bit float.
    pub color: &'a wgpu::Buffer,
    /// Where the result goes, 32-bit float.
    pub output: &'a wgpu::Buffer,
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
        match kernels.resolve(&context.device) {
            KernelSet::Simd => {
                let kernel = context.kernel(&simd::spec(shape, 1), &[]);
                Self { kernel, weights, pixels: shape.pixels() }
            }
            _ => Self { kernel: context.kernel(&SPEC, &[]), weights, pixels: 1 },
        }
    }

    /// The call that stores what `input` comes to; choose the tile with
    /// [`Dispatch::record_at`].
    #[must_use]
    pub fn dispatch(
        &self,
        device: &wgpu::Device,
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
            images.color.as_entire_binding(),
            images.output.as_entire_binding(),
        ];
        let group = self.kernel.bind(device, &resources);
        self.kernel.dispatch(group, [input.width.div_ceil(self.pixels), input.height, 1])
    }
}
