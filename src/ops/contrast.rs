//! The albedo's contrast: the logarithm of how much brighter a pixel is than its surroundings. To a
//! power that the network predicts, it is the texture by which a kernel pyramid divides light before
//! it gathers it, and multiplies it after.
//!
//! Light is often demodulated by the albedo as a whole, as in Bako et al., "Kernel-Predicting
//! Convolutional Networks for Denoising Monte Carlo Renderings" (2017).

use super::image::{ImageBinding, ImageFormat, contrast_features};
use super::input_process::{TILE, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::shader::ShaderRoot;

/// Bytes of a block's mean: three 32-bit floats, aligned to four.
const MEAN_BYTES: u64 = 16;

/// Averages the blocks of an albedo in this format.
#[must_use]
pub fn average_spec(albedo: ImageFormat) -> KernelSpec {
    spec("average", albedo)
}

/// Compares the pixels with the means.
#[must_use]
pub fn compare_spec(albedo: ImageFormat) -> KernelSpec {
    spec("compare", albedo)
}

fn spec(entry: &'static str, albedo: ImageFormat) -> KernelSpec {
    let means = Binding::BufferMut;
    KernelSpec {
        name: format!("contrast_{entry} {}", albedo.source_name()).into(),
        source: ShaderRoot::Module("contrast"),
        features: contrast_features(albedo).into(),
        entry,
        bindings: vec![TILE, means, albedo.source_binding(), Binding::TensorOut].into(),
        overrides: &["side"],
        workgroup: [8, 8, 1],
    }
}

/// A kernel of a pyramid's finest level that demodulates: it also reads the contrast, its last
/// binding.
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

    fn new(context: &Context, [width, height]: [u32; 2]) -> Self {
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

/// The contrast of the albedo to its means over blocks of `side` pixels, and the calls that compute
/// it. `tile` is the size of the tiles, width first; it and every tile's origin are multiples of
/// `side`. [`Dispatch::record_at`] selects the tile.
///
/// Needs [`bytes`] of GPU memory.
#[must_use]
pub fn contrast(
    context: &Context,
    tiles: &wgpu::Buffer,
    albedo: ImageBinding<'_>,
    tile: [u32; 2],
    side: u32,
) -> (Contrast, [Dispatch; 2]) {
    let contrast = Contrast::new(context, tile);
    let blocks = tile.map(|pixels| pixels / side);
    let means = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("mean albedo"),
        size: mean_bytes(tile, side),
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let calls = [(average_spec(albedo.format()), blocks), (compare_spec(albedo.format()), tile)];
    let calls = calls.map(|(spec, [columns, rows])| {
        let kernel = context.kernel(&spec, &[("side", f64::from(side))]);
        let resources = [
            tile_binding(tiles),
            means.as_entire_binding(),
            albedo.resource(),
            contrast.tensor.resource(),
        ];
        kernel.dispatch(kernel.bind(&context.device, &resources), [columns, rows, 1])
    });
    (contrast, calls)
}

/// GPU memory in bytes for a tile of this size, with `texel_bytes` per pixel of a tensor's quad.
#[must_use]
pub fn bytes(tile: [u32; 2], side: u32, texel_bytes: u64) -> u64 {
    tile.map(u64::from).iter().product::<u64>() * texel_bytes + mean_bytes(tile, side)
}

fn mean_bytes(tile: [u32; 2], side: u32) -> u64 {
    tile.map(|pixels| u64::from(pixels / side)).iter().product::<u64>() * MEAN_BYTES
}
