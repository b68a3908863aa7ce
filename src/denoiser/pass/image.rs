//! An image on the GPU, and checks whether a pass can use it.

use crate::error::{Error, Result};
use crate::ops::image::{Element, ImageFormat, storage};
use crate::ops::tile::Layout;

/// An image on the denoiser's device.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum PassImage<'a> {
    /// The first layer and mip level of a two-dimensional texture, with usage `TEXTURE_BINDING` for
    /// an input and `STORAGE_BINDING` for the output. [`PassDescriptor`](crate::PassDescriptor)
    /// lists the formats.
    Texture(&'a wgpu::Texture),
    /// Part of a storage buffer.
    Buffer {
        /// The buffer, with usage `STORAGE`.
        buffer: &'a wgpu::Buffer,
        /// The type of one channel.
        element: Element,
        /// Offset and strides of the pixels.
        layout: Layout,
    },
}

/// The role of an image in a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Color,
    Albedo,
    Normal { unorm: bool },
    Motion,
    Depth,
    Layer(usize),
    Output,
    LayerOutput(usize),
}

impl Role {
    pub(super) fn is_output(self) -> bool {
        matches!(self, Self::Output | Self::LayerOutput(_))
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Color => f.write_str("color"),
            Self::Albedo => f.write_str("albedo"),
            Self::Normal { .. } => f.write_str("normal"),
            Self::Motion => f.write_str("motion"),
            Self::Depth => f.write_str("depth"),
            Self::Layer(i) => write!(f, "layer {i}"),
            Self::Output => f.write_str("output"),
            Self::LayerOutput(i) => write!(f, "output of layer {i}"),
        }
    }
}

impl Role {
    fn accepts(self, format: wgpu::TextureFormat) -> bool {
        use wgpu::TextureFormat as Format;
        let float = storage(format).is_some();
        match self {
            Self::Color | Self::Layer(_) | Self::Output | Self::LayerOutput(_) => float,
            Self::Albedo => float || matches!(format, Format::Rgba8Unorm | Format::Rgba8UnormSrgb),
            Self::Normal { unorm: false } => float || format == Format::Rgba8Snorm,
            Self::Normal { unorm: true } => {
                float || matches!(format, Format::Rgba8Unorm | Format::Rgb10a2Unorm)
            }
            Self::Motion => float || matches!(format, Format::Rg16Float | Format::Rg32Float),
            Self::Depth => matches!(format, Format::R16Float | Format::R32Float),
        }
    }

    fn accepted(self) -> &'static str {
        match self {
            Self::Color | Self::Layer(_) | Self::Output | Self::LayerOutput(_) => {
                "Rgba16Float or Rgba32Float"
            }
            Self::Albedo => "Rgba16Float, Rgba32Float, Rgba8Unorm or Rgba8UnormSrgb",
            Self::Normal { unorm: false } => {
                "Rgba16Float, Rgba32Float or Rgba8Snorm, or with NormalEncoding::Unorm Rgba8Unorm \
                 or Rgb10a2Unorm"
            }
            Self::Normal { unorm: true } => "Rgba16Float, Rgba32Float, Rgba8Unorm or Rgb10a2Unorm",
            Self::Motion => "Rg16Float, Rg32Float, Rgba16Float or Rgba32Float",
            Self::Depth => "R16Float or R32Float",
        }
    }

    /// The minimum channels per pixel in a buffer.
    fn channels(self) -> u32 {
        match self {
            Self::Motion => 2,
            Self::Depth => 1,
            _ => 3,
        }
    }

    pub(super) fn texture_usage(self) -> (wgpu::TextureUsages, &'static str) {
        if self.is_output() {
            (wgpu::TextureUsages::STORAGE_BINDING, "STORAGE_BINDING")
        } else {
            (wgpu::TextureUsages::TEXTURE_BINDING, "TEXTURE_BINDING")
        }
    }
}

impl PassImage<'_> {
    /// The storage format of the pixels.
    #[must_use]
    pub fn format(&self) -> ImageFormat {
        match self {
            Self::Texture(texture) => ImageFormat::Texture(texture.format()),
            Self::Buffer { element, .. } => ImageFormat::Buffer(*element),
        }
    }

    /// Whether both use the same texture or buffer.
    pub(super) fn shares_memory(&self, other: &PassImage<'_>) -> bool {
        match (self, other) {
            (Self::Texture(a), PassImage::Texture(b)) => a == b,
            (Self::Buffer { buffer: a, .. }, PassImage::Buffer { buffer: b, .. }) => a == b,
            _ => false,
        }
    }

    /// Rejects an image that the kernels cannot use as `role`.
    pub(super) fn check(&self, role: Role, size: [u32; 2], limits: &wgpu::Limits) -> Result<()> {
        match self {
            Self::Texture(texture) => check_texture(texture, role, size),
            Self::Buffer { buffer, element, layout } => {
                check_layout(layout, role, size)?;
                check_buffer(buffer, *element, layout, role, size, limits)
            }
        }
    }

    /// Rejects an image that cannot be copied before an output overwrites it.
    pub(super) fn check_copy(&self, role: Role) -> Result<()> {
        let can = match self {
            Self::Texture(texture) => texture.usage().contains(wgpu::TextureUsages::COPY_SRC),
            Self::Buffer { buffer, .. } => buffer.usage().contains(wgpu::BufferUsages::COPY_SRC),
        };
        let what = if matches!(self, Self::Texture(_)) { "texture" } else { "buffer" };
        refuse_unless(can, || {
            format!(
                "{role} and an output are the same {what}, so {role} is copied first, but the {what} \
                 was created without the usage COPY_SRC; add it or give the output its own"
            )
        })
    }
}

fn check_texture(texture: &wgpu::Texture, role: Role, size: [u32; 2]) -> Result<()> {
    let [width, height] = size;
    let (format, found) = (texture.format(), [texture.width(), texture.height()]);
    refuse_unless(texture.dimension() == wgpu::TextureDimension::D2, || {
        format!("{role} must be a two-dimensional texture, found {:?}", texture.dimension())
    })?;
    refuse_unless(texture.sample_count() == 1, || {
        let samples = texture.sample_count();
        format!("{role} is a texture of {samples} samples a pixel, expected 1; resolve it first")
    })?;
    refuse_unless(found == size, || {
        let [w, h] = found;
        format!("{role} is a texture of {w}×{h} pixels, but the pass is {width}×{height}")
    })?;
    check_format(role, format)?;
    let (usage, name) = role.texture_usage();
    refuse_unless(texture.usage().contains(usage), || {
        format!("the texture of {role} was created without the usage {name}; add it")
    })
}

pub(super) fn check_format(role: Role, format: wgpu::TextureFormat) -> Result<()> {
    refuse_unless(role.accepts(format), || {
        format!("{role} is a texture of format {format:?}, expected {}", role.accepted())
    })
}

fn check_layout(layout: &Layout, role: Role, [width, height]: [u32; 2]) -> Result<()> {
    let (channels, last) = (layout.channels(), u64::from(width - 1));
    let least = role.channels();
    refuse_unless((least..=4).contains(&channels), || {
        format!("{role} needs {least} to 4 channels a pixel, but its layout has {channels}")
    })?;
    let row = last * u64::from(layout.pixel_stride) + u64::from(channels);
    let apart = layout.pixel_stride >= channels && u64::from(layout.row_stride) >= row;
    refuse_unless(apart, || {
        format!(
            "the pixels of {role} overlap: {layout:?} for rows of {width} pixels of {channels} \
             elements each"
        )
    })?;
    let last = layout.elements(width, height);
    refuse_unless(u32::try_from(last).is_ok(), || {
        format!("{role} ends at element {last} of its buffer; kernels count to {} only", u32::MAX)
    })
}

fn check_buffer(
    buffer: &wgpu::Buffer,
    element: Element,
    layout: &Layout,
    role: Role,
    [width, height]: [u32; 2],
    limits: &wgpu::Limits,
) -> Result<()> {
    let end = super::held::end_bytes(element, layout, [width, height]);
    refuse_unless(buffer.size() >= end, || {
        let found = buffer.size();
        format!("{role} of {width}×{height} pixels needs a buffer of {end} bytes, found {found}")
    })?;
    let bytes = end - super::held::begin_bytes(element, layout, limits);
    let most = limits.max_storage_buffer_binding_size;
    refuse_unless(bytes <= most, || {
        format!(
            "{role} takes {bytes} bytes of its buffer, but the device was created to bind at most \
             {most}; ask the adapter for more (see required_limits) or use a texture"
        )
    })?;
    refuse_unless(buffer.usage().contains(wgpu::BufferUsages::STORAGE), || {
        format!("the buffer of {role} was created without the usage STORAGE; add it")
    })
}

pub(super) fn refuse_unless(fine: bool, why: impl FnOnce() -> String) -> Result<()> {
    if fine { Ok(()) } else { Err(Error::Image(why())) }
}
