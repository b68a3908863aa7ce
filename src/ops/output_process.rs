//! From the network's output to the image: inverse transfer function, exposure, crop, store.

use super::image::{BLEND, ImageBinding, ImageFormat};
use super::input_process::{TILE, scale_binding, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::model::Encoding;

/// The kernel for a noisy colour and a result in these formats.
#[must_use]
pub fn spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let images = [color.source_binding(), output.target_binding(), BLEND];
    let text = include_str!("../../shaders/output_process.wgsl");
    KernelSpec {
        name: format!("output_process {} {}", color.source_name(), output.target_name()).into(),
        source: (color.result(output, 3) + text).into(),
        entry: "main",
        bindings: [TILE, Binding::TensorIn, Binding::Buffer].into_iter().chain(images).collect(),
        overrides: &["brightest", "transfer_function"],
        workgroup: [8, 8, 1],
    }
}

/// The images at the end of the network, and what it takes to make one of the other.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    /// [`Tile`](super::tile::Tile)s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// The 32-bit float that colour was multiplied by.
    pub input_scale: &'a wgpu::Buffer,
    /// The noisy colour.
    pub color: ImageBinding<'a>,
    /// Where the result goes.
    pub output: ImageBinding<'a>,
    /// Uniform of one 32-bit float: the share of the noisy colour in the result, from 0 to 1.
    pub blend: &'a wgpu::Buffer,
    /// How the network's output is encoded.
    pub encoding: Encoding,
}

/// The call that stores `input` into an image; choose the tile with [`Dispatch::record_at`].
#[must_use]
pub fn output_process(context: &Context, input: &GpuTensor, images: &Images<'_>) -> Dispatch {
    let spec = spec(images.color.format(), images.output.format());
    let kernel = context.kernel(&spec, &images.encoding.constants());
    let resources = [
        tile_binding(images.tiles),
        input.resource(),
        scale_binding(images.input_scale),
        images.color.resource(),
        images.output.resource(),
        images.blend.as_entire_binding(),
    ];
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [input.width, input.height, 1])
}
