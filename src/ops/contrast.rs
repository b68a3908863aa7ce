//! The albedo's contrast: the logarithm of the ratio of a pixel's albedo to the mean that the
//! weights of a kernel pyramid gather around it ([`gather_albedo`](super::gather::gather_albedo)).
//! Gathered light is multiplied by this ratio, raised to a power that the network predicts.
//!
//! At power 1, the result is the ratio of mean light to mean albedo, both gathered with the same
//! weights, times the pixel's own albedo: the ratio estimator of W. G. Cochran, "Sampling
//! Techniques" (1977). Bako et al. demodulate light by the albedo in "Kernel-Predicting
//! Convolutional Networks for Denoising Monte Carlo Renderings" (2017).

use crate::gpu::kernel::{Binding, Context, KernelSpec};
use crate::gpu::tensor::GpuTensor;

/// The demodulating variant of a kernel, which also reads the contrast, its last binding.
#[must_use]
pub fn demodulating(mut spec: KernelSpec) -> KernelSpec {
    spec.features.to_mut().push("demodulates");
    spec.bindings.to_mut().push(Binding::Image);
    KernelSpec { name: format!("{} demodulating", spec.name).into(), ..spec }
}

/// The contrast of a tile.
#[derive(Clone, Debug)]
pub struct Contrast {
    /// One quad; its fourth channel is 0.
    pub tensor: GpuTensor,
    view: wgpu::TextureView,
}

impl Contrast {
    /// No contrast, for layers that are not light: new textures are zero, and reads beyond them
    /// return zero too.
    #[must_use]
    pub fn none(context: &Context) -> Self {
        Self::new(context, [1, 1])
    }

    /// Room for the contrast of a tile of this size, width first. Needs [`bytes`] of GPU memory.
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
