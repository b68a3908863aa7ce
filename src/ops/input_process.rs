//! From images to the network's input: sanitise, expose, transfer function, layout, padding.

use super::tile::Tile;
use super::{ChannelMap, GpuTensor};
use crate::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::model::Inputs;

/// The kernel.
pub const SPEC: KernelSpec = KernelSpec {
    name: std::borrow::Cow::Borrowed("input_process"),
    source: std::borrow::Cow::Borrowed(include_str!("../../shaders/input_process.wgsl")),
    entry: "main",
    bindings: &[
        Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true },
        Binding::Buffer,
        Binding::Buffer,
        Binding::Buffer,
        Binding::Buffer,
        Binding::TensorOut,
    ],
    overrides: &["has_albedo", "has_normal"],
    workgroup: [8, 8, 1],
};

/// How the network's input is stored: each image's three channels have a layer of their own.
#[must_use]
pub fn channel_map(channels: usize) -> ChannelMap {
    let image = |first: usize| [Some(first), Some(first + 1), Some(first + 2), None];
    (0..channels).step_by(3).flat_map(image).collect()
}

/// What the kernel reads.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// [`Tile`]s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// Colour, 32-bit float.
    pub color: &'a wgpu::Buffer,
    /// Albedo, 32-bit float in `[0, 1]`.
    pub albedo: Option<&'a wgpu::Buffer>,
    /// Normal, 32-bit float in `[−1, 1]`.
    pub normal: Option<&'a wgpu::Buffer>,
    /// One 32-bit float: what colour is multiplied by.
    pub input_scale: &'a wgpu::Buffer,
}

impl Sources<'_> {
    /// Which images there are.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    /// What to bind for albedo and normal: an absent image is never read, but a binding cannot
    /// stay empty.
    #[must_use]
    pub fn auxiliary(&self) -> [&wgpu::Buffer; 2] {
        [self.albedo, self.normal].map(|image| image.unwrap_or(self.color))
    }
}

/// The call that fills `output`; choose the tile with [`Dispatch::record_at`].
#[must_use]
pub fn input_process(context: &Context, sources: &Sources<'_>, output: &GpuTensor) -> Dispatch {
    let Inputs { albedo, normal } = sources.inputs();
    let flag = |present: bool| f64::from(u8::from(present));
    let constants = [("has_albedo", flag(albedo)), ("has_normal", flag(normal))];
    let kernel = context.kernel(&SPEC, &constants);
    let [albedo, normal] = sources.auxiliary();
    let resources = [
        tile_binding(sources.tiles),
        sources.color.as_entire_binding(),
        albedo.as_entire_binding(),
        normal.as_entire_binding(),
        sources.input_scale.as_entire_binding(),
        output.resource(),
    ];
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width, output.height, 1])
}

/// One [`Tile`] of a buffer of many.
#[must_use]
pub fn tile_binding(tiles: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: tiles,
        offset: 0,
        size: std::num::NonZeroU64::new(size_of::<Tile>() as u64),
    })
}
