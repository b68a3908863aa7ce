//! The albedo's contrast: the logarithm of how much brighter a pixel is than what the weights of a
//! kernel pyramid gather around it ([`gather_albedo`](super::gather::gather_albedo)). To a power that
//! the network predicts, light is multiplied by it.
//!
//! With light gathered by the same weights, this is the ratio of mean light to mean albedo, times the
//! pixel's own albedo: the ratio estimator of W. G. Cochran, "Sampling Techniques" (1977). Light is
//! demodulated by the albedo as in Bako et al., "Kernel-Predicting Convolutional Networks for
//! Denoising Monte Carlo Renderings" (2017).

use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::tensor::GpuTensor;

/// A kernel that demodulates: it also reads the contrast, its last binding.
#[must_use]
pub fn demodulating(mut spec: KernelSpec) -> KernelSpec {
    spec.features.to_mut().push("demodulates");
    spec.bindings.to_mut().push(Binding::Image);
    KernelSpec { name: format!("{} demodulating", spec.name).into(), ..spec }
}

/// The contrast of a tile.
#[derive(Clone, Debug)]
pub struct Contrast {
    /// One quad, of which the fourth channel is 0.
    pub tensor: GpuTensor,
    view: wgpu::TextureView,
}

impl Contrast {
    /// None at all, for what is not light: new textures are zero, and reads beyond them return zero
    /// too.
    #[must_use]
    pub fn none(context: &Context) -> Self {
        Self::new(context, [1, 1])
    }

    /// Room for that of a tile, width first. Needs [`bytes`] of GPU memory.
    #[must_use]
    pub fn new(context: &Context, [width, height]: [u32; 2]) -> Self {
        let texture = context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("contrast"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: context.precision.texture_format(),
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self {
            tensor: GpuTensor::of(&texture, 0, 1),
            view: texture.create_view(&Default::default()),
        }
    }

    /// The binding of [`demodulating`] kernels.
    #[must_use]
    pub fn resource(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::TextureView(&self.view)
    }
}

/// GPU memory in bytes for a tile of this size, with `texel_bytes` per pixel of a tensor's quad.
#[must_use]
pub fn bytes(tile: [u32; 2], texel_bytes: u64) -> u64 {
    tile.map(u64::from).iter().product::<u64>() * texel_bytes
}
