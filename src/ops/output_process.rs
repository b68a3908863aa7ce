//! From the network's output to the image: inverse transfer function, exposure, crop, store.

use super::GpuTensor;
use super::input_process::tile_binding;
use super::tile::Tile;
use crate::kernel::{Binding, Context, Dispatch, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = KernelSpec {
    name: std::borrow::Cow::Borrowed("output_process"),
    source: std::borrow::Cow::Borrowed(include_str!("../../shaders/output_process.wgsl")),
    entry: "main",
    bindings: &[
        Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true },
        Binding::TensorIn,
        Binding::Buffer,
        Binding::BufferMut,
    ],
    overrides: &[],
    workgroup: [8, 8, 1],
};

/// The call that stores `input` into `image`; choose the tile with [`Dispatch::record_at`].
/// `tiles` holds [`Tile`]s, `input_scale` the 32-bit float that colour was multiplied by.
#[must_use]
pub fn output_process(
    context: &Context,
    tiles: &wgpu::Buffer,
    input: &GpuTensor,
    input_scale: &wgpu::Buffer,
    image: &wgpu::Buffer,
) -> Dispatch {
    let kernel = context.kernel(&SPEC, &[]);
    let resources = [
        tile_binding(tiles),
        input.resource(),
        input_scale.as_entire_binding(),
        image.as_entire_binding(),
    ];
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [input.width, input.height, 1])
}
