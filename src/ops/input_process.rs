//! Turns images into the network's input: repair, exposure, transfer function, layout, padding.

use super::channel_map::ChannelMap;
use super::image::{ImageBinding, ImageFormat, source_features};
use super::tile::Tile;
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::model::{Encoding, Inputs};
use crate::shader::ShaderRoot;

/// The kernel for color, albedo and normal in these formats.
#[must_use]
pub fn spec(formats: [ImageFormat; 3]) -> KernelSpec {
    KernelSpec {
        name: format!("input_process {}", source_names(formats)).into(),
        source: ShaderRoot::Module("input_process"),
        features: source_features(formats).into(),
        entry: "main",
        bindings: bindings(formats).into(),
        overrides: &OVERRIDES,
        workgroup: [8, 8, 1],
    }
}

/// The overrides for which images exist and how they are encoded.
pub(super) const OVERRIDES: [&str; 7] = [
    "brightest",
    "has_albedo",
    "has_normal",
    "outlier",
    "transfer_function",
    "unorm_normal",
    "zero_padding",
];

/// The bindings of this kernel, and the first ones of [`input_conv`](mod@super::input_conv).
pub(super) fn bindings(formats: [ImageFormat; 3]) -> Vec<Binding> {
    let [color, albedo, normal] = formats.map(ImageFormat::source_binding);
    vec![TILE, color, albedo, normal, Binding::Buffer, Binding::TensorOut]
}

/// The binding of the [`Tile`]s.
pub(super) const TILE: Binding =
    Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true };

/// The formats as part of a kernel's name.
pub(super) fn source_names(formats: [ImageFormat; 3]) -> String {
    formats.map(ImageFormat::source_name).join(" ")
}

/// How the network's input is stored: the three channels of each image have a layer of their own.
#[must_use]
pub fn channel_map(channels: usize) -> ChannelMap {
    let image = |first: usize| [Some(first), Some(first + 1), Some(first + 2), None];
    (0..channels).step_by(3).flat_map(image).collect()
}

/// The resources the kernel reads.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// [`Tile`]s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// Color.
    pub color: ImageBinding<'a>,
    /// Albedo in `[0, 1]`.
    pub albedo: Option<ImageBinding<'a>>,
    /// Normal, stored according to `unorm_normal`.
    pub normal: Option<ImageBinding<'a>>,
    /// Whether normals are stored as `0.5 n + 0.5`, with 0 where no surface was hit.
    pub unorm_normal: bool,
    /// One 32-bit float: the factor for color.
    pub input_scale: &'a wgpu::Buffer,
    /// The encoding to apply.
    pub encoding: Encoding,
}

impl<'a> Sources<'a> {
    /// The auxiliary images that are present.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    /// The images to read.
    #[must_use]
    pub fn present(&self) -> Vec<ImageBinding<'a>> {
        [Some(self.color), self.albedo, self.normal].into_iter().flatten().collect()
    }

    /// The images to bind as color, albedo and normal. An absent image is never read, but its
    /// binding cannot stay empty.
    #[must_use]
    pub fn images(&self) -> [ImageBinding<'a>; 3] {
        [self.color, self.albedo.unwrap_or(self.color), self.normal.unwrap_or(self.color)]
    }

    /// The overrides of the shader that makes the network's input.
    #[must_use]
    pub fn input_constants(&self) -> [(&'static str, f64); 7] {
        let Inputs { albedo, normal } = self.inputs();
        let flag = |name, value| (name, f64::from(u8::from(value)));
        let [curve, brightest, outlier] = self.encoding.constants();
        [
            flag("has_albedo", albedo),
            flag("has_normal", normal),
            flag("unorm_normal", self.unorm_normal),
            flag("zero_padding", self.encoding.zero_padding),
            curve,
            brightest,
            outlier,
        ]
    }
}

/// The call that fills `output`. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn input_process(context: &Context, sources: &Sources<'_>, output: &GpuTensor) -> Dispatch {
    let formats = sources.images().map(|image| image.format());
    let kernel = context.kernel(&spec(formats), &sources.input_constants());
    let group = kernel.bind(&context.device, &resources(sources, output));
    kernel.dispatch(group, [output.width, output.height, 1])
}

/// The resources for [`bindings`].
pub(super) fn resources<'a>(
    sources: &Sources<'a>,
    output: &'a GpuTensor,
) -> Vec<wgpu::BindingResource<'a>> {
    let [color, albedo, normal] = sources.images().map(|image| image.resource());
    let (tile, scale) = (tile_binding(sources.tiles), scale_binding(sources.input_scale));
    vec![tile, color, albedo, normal, scale, output.resource()]
}

/// The 32-bit float at the start of a buffer.
#[must_use]
pub fn scale_binding(input_scale: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: input_scale,
        offset: 0,
        size: std::num::NonZeroU64::new(size_of::<f32>() as u64),
    })
}

/// One [`Tile`] of a buffer; the dynamic offset selects it.
#[must_use]
pub fn tile_binding(tiles: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: tiles,
        offset: 0,
        size: std::num::NonZeroU64::new(size_of::<Tile>() as u64),
    })
}
