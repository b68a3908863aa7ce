//! Turns the network's output into the image: inverse transfer function, inverse exposure, crop,
//! store.

use super::image::ImageBinding;
use super::image::{BLEND, ImageFormat, result_features};
use super::input_process::{TILE, scale_binding, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::model::Encoding;
use crate::shader::ShaderRoot;

/// The kernel for noisy color and result in these formats.
#[must_use]
pub fn spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let mut bindings = result_bindings(color, output);
    bindings.push(Binding::TensorIn);
    KernelSpec {
        name: format!("output_process {} {}", color.source_name(), output.target_name()).into(),
        source: ShaderRoot::Module("output_process"),
        features: result_features(color, output).into(),
        entry: "main",
        bindings: bindings.into(),
        overrides: &["brightest", "transfer_function"],
        workgroup: [8, 8, 1],
    }
}

/// The bindings of this kernel before its input, and the first ones of [`head`](mod@super::head).
pub(super) fn result_bindings(color: ImageFormat, output: ImageFormat) -> Vec<Binding> {
    vec![TILE, color.source_binding(), output.target_binding(), BLEND, Binding::Buffer]
}

/// The images at the end of the network, and how they relate.
#[derive(Clone, Copy, Debug)]
pub struct ResultImages<'a> {
    /// [`Tile`](super::tile::Tile)s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// The 32-bit float that color was multiplied by.
    pub input_scale: &'a wgpu::Buffer,
    /// The noisy color.
    pub color: ImageBinding<'a>,
    /// Receives the result.
    pub output: ImageBinding<'a>,
    /// Uniform holding one 32-bit float: the share of noisy color in the result, from 0 to 1.
    pub blend: &'a wgpu::Buffer,
    /// How the network's output is encoded.
    pub encoding: Encoding,
}

impl<'a> ResultImages<'a> {
    /// The resources for [`result_bindings`].
    pub(super) fn resources(&self) -> Vec<wgpu::BindingResource<'a>> {
        vec![
            tile_binding(self.tiles),
            self.color.resource(),
            self.output.resource(),
            self.blend.as_entire_binding(),
            scale_binding(self.input_scale),
        ]
    }
}

/// The call that stores `input` into an image. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn output_process(context: &Context, input: &GpuTensor, images: &ResultImages<'_>) -> Dispatch {
    let spec = spec(images.color.format(), images.output.format());
    let kernel = context.kernel(&spec, &images.encoding.constants());
    let mut resources = images.resources();
    resources.push(input.resource());
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [input.width, input.height, 1])
}
