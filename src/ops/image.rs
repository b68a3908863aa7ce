//! Images of a renderer's, as kernels read and write them: textures, or storage buffers of 16-bit
//! or 32-bit floats. A kernel's text begins with the functions for the kinds of its images
//! (`shaders/image`), which give and take pixels as 32-bit floats, so that nothing is converted
//! or copied beforehand.

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

    /// The functions `load_…` and `alpha_of_…` for an image called `name`, bound at `binding`. Its
    /// layout is the member `name` of the variable `uniform`.
    #[must_use]
    pub(crate) fn reading(self, name: &str, binding: usize, uniform: &str) -> String {
        let text = match self {
            Self::Buffer(Element::F32) => include_str!("../../shaders/image/read_f32.wgsl"),
            Self::Buffer(Element::F16) => include_str!("../../shaders/image/read_f16.wgsl"),
            Self::Texture(_) => include_str!("../../shaders/image/read_texture.wgsl"),
        };
        let text = text.replace("BINDING", &binding.to_string());
        text.replace("IMAGE", name).replace("UNIFORM", uniform)
    }

    /// What the texts of [`filling`](Self::filling) share, once per kernel.
    pub(crate) const AROUND: &str = include_str!("../../shaders/image/around.wgsl");

    /// The function `filled_…` for an image called `name` that [`reading`](Self::reading) reads.
    #[must_use]
    pub(crate) fn filling(name: &str) -> String {
        include_str!("../../shaders/image/filled.wgsl").replace("IMAGE", name)
    }

    /// The function `store` for the image `output` bound at `binding`. Its layout is
    /// `tile.output`. A finite value that the format cannot hold is clamped.
    ///
    /// # Panics
    /// If kernels cannot write textures of the format.
    #[must_use]
    pub(crate) fn storing(self, binding: usize) -> String {
        let text = match self {
            Self::Buffer(Element::F32) => include_str!("../../shaders/image/store_f32.wgsl").into(),
            Self::Buffer(Element::F16) => include_str!("../../shaders/image/store_f16.wgsl").into(),
            Self::Texture(format) => {
                let text = include_str!("../../shaders/image/store_texture.wgsl");
                let (name, largest) = storage(format).expect("pass() lets no other format through");
                text.replace("FORMAT", name).replace("LARGEST)", &format!("{largest})"))
            }
        };
        text.replace("BINDING", &binding.to_string())
    }

    /// The functions `encode` and `decode`, and the override that chooses among them.
    pub(crate) const ENCODING: &str = include_str!("../../shaders/image/encoding.wgsl");

    /// The functions `decode`, `store_denoised` and `store_noisy` between the image `color` in this format,
    /// bound at `binding`, and `output`, bound after it; [`BLEND`] comes third.
    #[must_use]
    pub(crate) fn result(self, output: Self, binding: usize) -> String {
        let text = include_str!("../../shaders/image/result.wgsl");
        Self::ENCODING.to_string()
            + &self.reading("color", binding, "tile")
            + Self::AROUND
            + &Self::filling("color")
            + &output.storing(binding + 1)
            + &text.replace("BINDING", &(binding + 2).to_string())
    }

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

    /// The kind as a part of a kernel's name: formats that share a text share a name.
    #[must_use]
    pub(crate) fn source_name(self) -> &'static str {
        match self {
            Self::Buffer(Element::F32) => "f32",
            Self::Buffer(Element::F16) => "f16",
            Self::Texture(_) => "texture",
        }
    }

    /// The same for an image that is written.
    #[must_use]
    pub(crate) fn target_name(self) -> &'static str {
        match self {
            Self::Buffer(_) => self.source_name(),
            Self::Texture(format) => storage(format).map_or("texture", |(name, _)| name),
        }
    }
}

/// The share of the noisy colour in the result: a 32-bit float.
pub const BLEND: Binding = Binding::Uniform { bytes: 4, dynamic: false };

/// The texture formats that kernels can write, with their names in WGSL and the largest finite
/// values that they are given.
#[must_use]
pub fn storage(format: wgpu::TextureFormat) -> Option<(&'static str, &'static str)> {
    match format {
        wgpu::TextureFormat::Rgba16Float => Some(("rgba16float", "65504.0")),
        wgpu::TextureFormat::Rgba32Float => Some(("rgba32float", "3.4028234e38")),
        _ => None,
    }
}
