//! A renderer's images as kernels read and write them: textures, or storage buffers of 16-bit or
//! 32-bit floats. The modules of `shaders/common` named after images have a variant for each. They
//! load and store pixels as 32-bit floats, so nothing is converted or copied beforehand.

use std::num::NonZeroU64;

use crate::gpu::kernel::Binding;

/// The element type of an image in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// 16-bit floats. Shaders convert them with a core feature of WGSL that wgpu calls
    /// `SHADER_F16_IN_F32`; without it, as on some CPU drivers, creating a pass fails.
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

/// The storage format of an image's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// In a storage buffer.
    Buffer(Element),
    /// In a texture.
    Texture(wgpu::TextureFormat),
}

/// An image to bind.
#[derive(Clone, Copy, Debug)]
pub enum ImageBinding<'a> {
    /// Part of a storage buffer.
    Buffer {
        /// The buffer.
        buffer: &'a wgpu::Buffer,
        /// The element type.
        element: Element,
        /// First bound byte.
        offset: u64,
        /// Number of bound bytes; `None` for the rest of the buffer.
        size: Option<NonZeroU64>,
    },
    /// A two-dimensional texture view with one mip level.
    Texture(&'a wgpu::TextureView),
}

impl<'a> From<&'a wgpu::Buffer> for ImageBinding<'a> {
    /// A whole buffer of 32-bit floats.
    fn from(buffer: &'a wgpu::Buffer) -> Self {
        Self::Buffer { buffer, element: Element::F32, offset: 0, size: None }
    }
}

impl<'a> ImageBinding<'a> {
    /// The storage format of the pixels.
    #[must_use]
    pub fn format(&self) -> ImageFormat {
        match self {
            Self::Buffer { element, .. } => ImageFormat::Buffer(*element),
            Self::Texture(view) => ImageFormat::Texture(view.texture().format()),
        }
    }

    /// The image as a binding resource.
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
    /// 32-bit floats in a buffer, the format of the blocking call.
    pub const F32: Self = Self::Buffer(Element::F32);

    /// Bytes per pixel, with three elements in a buffer.
    #[must_use]
    pub(crate) fn pixel_bytes(self) -> u32 {
        match self {
            Self::Buffer(element) => 3 * element.bytes(),
            Self::Texture(format) => format.block_copy_size(None).unwrap_or(0),
        }
    }

    /// The binding of an image to read.
    #[must_use]
    pub(crate) fn source_binding(self) -> Binding {
        match self {
            Self::Buffer(_) => Binding::Buffer,
            Self::Texture(_) => Binding::Image,
        }
    }

    /// The binding of an image to write.
    #[must_use]
    pub(crate) fn target_binding(self) -> Binding {
        match self {
            Self::Buffer(_) => Binding::BufferMut,
            Self::Texture(format) => Binding::ImageOut(format),
        }
    }

    /// The shader feature for reading an image in this format: `buffer` for 16-bit floats in a
    /// buffer, `texture` for a texture, `None` for the default.
    fn source_feature(self, buffer: &'static str, texture: &'static str) -> Option<&'static str> {
        match self {
            Self::Buffer(Element::F32) => None,
            Self::Buffer(Element::F16) => Some(buffer),
            Self::Texture(_) => Some(texture),
        }
    }

    /// The shader feature for writing an image in this format; `None` for the default.
    ///
    /// # Panics
    /// Panics if kernels cannot write textures of this format.
    fn target_feature(self) -> Option<&'static str> {
        match self {
            Self::Buffer(Element::F32) => None,
            Self::Buffer(Element::F16) => Some("output_f16"),
            Self::Texture(format) => {
                Some(storage(format).expect("pass() lets no other format through"))
            }
        }
    }

    /// The kind of source as part of a kernel's name: formats that share a shader text share a
    /// name.
    #[must_use]
    pub(crate) fn source_name(self) -> &'static str {
        self.source_feature("f16", "texture").unwrap_or("f32")
    }

    /// The kind of target as part of a kernel's name.
    #[must_use]
    pub(crate) fn target_name(self) -> &'static str {
        self.target_feature().map_or("f32", |feature| feature.trim_start_matches("output_"))
    }
}

/// The share of noisy color in the result: a 32-bit float.
pub const BLEND: Binding = Binding::Uniform { bytes: 4, dynamic: false };

/// The features of a kernel that reads color in this format.
#[must_use]
pub(crate) fn color_features(color: ImageFormat) -> Vec<&'static str> {
    color.source_feature("color_f16", "color_texture").into_iter().collect()
}

/// The features of a kernel that reads color, albedo and normal in these formats.
#[must_use]
pub(crate) fn source_features([color, albedo, normal]: [ImageFormat; 3]) -> Vec<&'static str> {
    let mut features = color_features(color);
    features.push("auxiliary");
    features.extend(albedo_feature(albedo));
    features.extend(normal.source_feature("normal_f16", "normal_texture"));
    features
}

/// The feature of a kernel that reads an albedo in this format; `None` for the default.
#[must_use]
pub(crate) fn albedo_feature(albedo: ImageFormat) -> Option<&'static str> {
    albedo.source_feature("albedo_f16", "albedo_texture")
}

/// The features of a kernel that, besides a layer, reads the beauty in this format.
#[must_use]
pub(crate) fn beauty_features(beauty: ImageFormat) -> Vec<&'static str> {
    let format = beauty.source_feature("beauty_f16", "beauty_texture");
    ["layer"].into_iter().chain(format).collect()
}

/// The features of a kernel that reads noisy color and writes a result in these formats.
#[must_use]
pub(crate) fn result_features(color: ImageFormat, output: ImageFormat) -> Vec<&'static str> {
    let mut features = color_features(color);
    features.extend(output.target_feature());
    features
}

/// The features of the kernel that averages frames, for motion, albedo, normal, depth and result in
/// these formats.
#[must_use]
pub(crate) fn accumulate_features(
    [motion, albedo, normal, depth]: [ImageFormat; 4],
    output: ImageFormat,
) -> Vec<&'static str> {
    let features = [
        Some("accumulate"),
        motion.source_feature("motion_f16", "motion_texture"),
        albedo_feature(albedo),
        normal.source_feature("normal_f16", "normal_texture"),
        depth.source_feature("depth_f16", "depth_texture"),
        output.target_feature(),
    ];
    features.into_iter().flatten().collect()
}

/// The features of the kernels that average a further layer, for motion and result in these
/// formats.
#[must_use]
pub(crate) fn accumulate_layer_features(
    motion: ImageFormat,
    output: ImageFormat,
) -> Vec<&'static str> {
    let motion = motion.source_feature("motion_f16", "motion_texture");
    motion.into_iter().chain(output.target_feature()).collect()
}

/// The feature of kernels that write textures of this format; `None` if they cannot.
#[must_use]
pub fn storage(format: wgpu::TextureFormat) -> Option<&'static str> {
    match format {
        wgpu::TextureFormat::Rgba16Float => Some("output_rgba16float"),
        wgpu::TextureFormat::Rgba32Float => Some("output_rgba32float"),
        _ => None,
    }
}
