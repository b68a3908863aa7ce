//! Images of a renderer's, as kernels read and write them: textures, or storage buffers of 16-bit
//! or 32-bit floats. The modules `color`, `albedo`, `normal` and `output` of `shaders/common` have a
//! variant for each and give and take pixels as 32-bit floats, so that nothing is converted or
//! copied beforehand.

use std::num::NonZeroU64;

use crate::gpu::kernel::Binding;

/// What the elements of an image in a buffer are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// 16-bit floats. Shaders convert them with a feature of WGSL's core that wgpu calls
    /// `SHADER_F16_IN_F32`; without it, as on some CPU drivers, a pass is an error.
    F16,
    /// 32-bit floats.
    F32,
}

impl Element {
    /// Size in bytes.
    #[must_use]
    pub fn bytes(self) -> u32 {
        match self {
            Self::F16 => 2,
            Self::F32 => 4,
        }
    }
}

/// How the pixels of an image are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// In a storage buffer.
    Buffer(Element),
    /// In a texture.
    Texture(wgpu::TextureFormat),
}

/// An image to be bound.
#[derive(Clone, Copy, Debug)]
pub enum ImageBinding<'a> {
    /// A part of a storage buffer.
    Buffer {
        /// The buffer.
        buffer: &'a wgpu::Buffer,
        /// What stands in it.
        element: Element,
        /// First byte that is bound.
        offset: u64,
        /// Bytes that are bound; `None` for all there are.
        size: Option<NonZeroU64>,
    },
    /// A view of a texture: two dimensions, one level.
    Texture(&'a wgpu::TextureView),
}

impl<'a> From<&'a wgpu::Buffer> for ImageBinding<'a> {
    /// All of a buffer of 32-bit floats.
    fn from(buffer: &'a wgpu::Buffer) -> Self {
        Self::Buffer { buffer, element: Element::F32, offset: 0, size: None }
    }
}

impl<'a> ImageBinding<'a> {
    /// How the pixels are stored.
    #[must_use]
    pub fn format(&self) -> ImageFormat {
        match self {
            Self::Buffer { element, .. } => ImageFormat::Buffer(*element),
            Self::Texture(view) => ImageFormat::Texture(view.texture().format()),
        }
    }

    /// What a bind group takes.
    #[must_use]
    pub fn resource(&self) -> wgpu::BindingResource<'a> {
        match *self {
            Self::Buffer { buffer, offset, size, .. } => {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })
            }
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

impl ImageFormat {
    /// 32-bit floats in a buffer, as the blocking call has them.
    pub const F32: Self = Self::Buffer(Element::F32);

    /// How an image that is read is bound.
    #[must_use]
    pub(crate) fn source_binding(self) -> Binding {
        match self {
            Self::Buffer(_) => Binding::Buffer,
            Self::Texture(_) => Binding::Image,
        }
    }

    /// How an image that is written is bound.
    #[must_use]
    pub(crate) fn target_binding(self) -> Binding {
        match self {
            Self::Buffer(_) => Binding::BufferMut,
            Self::Texture(format) => Binding::ImageOut(format),
        }
    }

    /// The feature by which kernels read an image in this format, if it is not the default: `buffer`
    /// for 16-bit floats in a buffer, `texture` for a texture.
    fn source_feature(self, buffer: &'static str, texture: &'static str) -> Option<&'static str> {
        match self {
            Self::Buffer(Element::F32) => None,
            Self::Buffer(Element::F16) => Some(buffer),
            Self::Texture(_) => Some(texture),
        }
    }

    /// The feature of kernels that write an image in this format, if it is not the default.
    ///
    /// # Panics
    /// If kernels cannot write textures of the format.
    fn target_feature(self) -> Option<&'static str> {
        match self {
            Self::Buffer(Element::F32) => None,
            Self::Buffer(Element::F16) => Some("output_f16"),
            Self::Texture(format) => {
                Some(storage(format).expect("pass() lets no other format through"))
            }
        }
    }

    /// The kind as a part of a kernel's name: formats that share a text share a name.
    #[must_use]
    pub(crate) fn source_name(self) -> &'static str {
        self.source_feature("f16", "texture").unwrap_or("f32")
    }

    /// The same for an image that is written.
    #[must_use]
    pub(crate) fn target_name(self) -> &'static str {
        self.target_feature().map_or("f32", |feature| feature.trim_start_matches("output_"))
    }
}

/// The share of the noisy colour in the result: a 32-bit float.
pub const BLEND: Binding = Binding::Uniform { bytes: 4, dynamic: false };

/// The features of a kernel that reads a colour in this format.
#[must_use]
pub(crate) fn color_features(color: ImageFormat) -> Vec<&'static str> {
    color.source_feature("color_f16", "color_texture").into_iter().collect()
}

/// The features of a kernel that reads colour, albedo and normal in these formats.
#[must_use]
pub(crate) fn source_features([color, albedo, normal]: [ImageFormat; 3]) -> Vec<&'static str> {
    let mut features = color_features(color);
    features.push("auxiliary");
    features.extend(albedo.source_feature("albedo_f16", "albedo_texture"));
    features.extend(normal.source_feature("normal_f16", "normal_texture"));
    features
}

/// The features of a kernel that reads a noisy colour and writes a result in these formats.
#[must_use]
pub(crate) fn result_features(color: ImageFormat, output: ImageFormat) -> Vec<&'static str> {
    let mut features = color_features(color);
    features.extend(output.target_feature());
    features
}

/// The feature of kernels that write textures of a format, if they can.
#[must_use]
pub fn storage(format: wgpu::TextureFormat) -> Option<&'static str> {
    match format {
        wgpu::TextureFormat::Rgba16Float => Some("output_rgba16float"),
        wgpu::TextureFormat::Rgba32Float => Some("output_rgba32float"),
        _ => None,
    }
}
