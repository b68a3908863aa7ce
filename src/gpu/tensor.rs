//! Tensors on the GPU.

use super::kernel::Context;
use super::precision::Precision;

/// A tensor on the GPU: texel `(x, y)` of array layer `q` holds channels `4q … 4q + 3`.
#[derive(Clone, Debug)]
pub struct GpuTensor {
    /// All layers of the tensor, and no others of the texture.
    pub view: wgpu::TextureView,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Array layers: a quarter of the channels, rounded up.
    pub quads: u32,
}

impl GpuTensor {
    /// A texture for tensors: `size` (width, height) pixels with `quads` layers.
    #[must_use]
    pub fn texture(context: &Context, size: [u32; 2], quads: u32) -> wgpu::Texture {
        Self::texture_in(context, size, quads, context.precision.texture_format())
    }

    /// A level of a kernel pyramid, in 32-bit floats whatever the precision of tensors: one quad, or
    /// two with an albedo.
    #[must_use]
    pub fn light(context: &Context, size: [u32; 2], quads: u32) -> Self {
        let format = wgpu::TextureFormat::Rgba32Float;
        Self::of(&Self::texture_in(context, size, quads, format), 0, quads)
    }

    /// The first quad of a [`light`](Self::light), without the albedo.
    #[must_use]
    pub fn first_quad(&self) -> Self {
        Self::of(self.view.texture(), 0, 1)
    }

    fn texture_in(
        context: &Context,
        [width, height]: [u32; 2],
        quads: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tensor"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: quads },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Layers `first_quad .. first_quad + quads` of a texture.
    #[must_use]
    pub fn of(texture: &wgpu::Texture, first_quad: u32, quads: u32) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            base_array_layer: first_quad,
            array_layer_count: Some(quads),
            ..Default::default()
        });
        Self { view, width: texture.width(), height: texture.height(), quads }
    }

    /// Size in bytes.
    #[must_use]
    pub fn bytes(&self, precision: Precision) -> f64 {
        let texels = f64::from(self.width) * f64::from(self.height) * f64::from(self.quads);
        texels * precision.texel_bytes() as f64
    }

    /// The view as a binding resource.
    #[must_use]
    pub fn resource(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::TextureView(&self.view)
    }
}
