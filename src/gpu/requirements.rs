//! Features and limits to request from an adapter.

use super::matrix_shape::MatrixShape;
use super::precision::Precision;

/// The features worth requesting that this adapter supports. None is required.
///
/// | feature | used for | without it |
/// |---|---|---|
/// | `SUBGROUP` | the kernels for CPU drivers | CPU drivers run the slower tiled kernels; GPUs do not use it |
/// | `TIMESTAMP_QUERY` | [`Denoiser::profile`](crate::Denoiser::profile) on GPUs | profiling fails on GPUs; CPU drivers use the wall clock anyway |
/// | `SHADER_F16` | [`KernelSet::Half`](crate::KernelSet::Half), on request | asking for it fails |
/// | `PIPELINE_CACHE` | [`Options::pipeline_cache`](crate::Options::pipeline_cache), on Vulkan | every run compiles the kernels anew, unless the driver caches them |
#[must_use]
pub fn required_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    use wgpu::Features;
    let useful = Features::SUBGROUP | Features::TIMESTAMP_QUERY | Features::PIPELINE_CACHE;
    adapter.features() & (useful | Features::SHADER_F16)
}

/// Additional features for the matrix kernels; empty if the adapter multiplies no suitable
/// matrices. They are experimental in wgpu, so requesting them means filling in
/// `DeviceDescriptor::experimental_features`, which needs an `unsafe` block in the caller.
#[must_use]
pub fn matrix_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    let shapes = [Precision::F32, Precision::F16].map(|p| MatrixShape::of(adapter, p));
    let features = shapes.into_iter().flatten().map(MatrixShape::features);
    features.fold(wgpu::Features::empty(), |all, one| all | one)
}

/// The limits worth requesting: WebGPU's defaults, some raised to the adapter's own. A device with
/// the default limits works too.
///
/// | limit | used for | with the default |
/// |---|---|---|
/// | `max_storage_buffer_binding_size`, `max_buffer_size` | images in buffers, and tiles of the blocking call | 128 MiB: images of up to 11 Mpixel in 32-bit RGB, smaller tiles |
/// | `max_texture_dimension_2d` | large tiles | tiles of up to 8192 pixels a side |
/// | `max_texture_array_layers` | wide networks | 256: tensors of up to 1024 channels, more than the built-in weights have |
#[must_use]
pub fn required_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let offered = adapter.limits();
    wgpu::Limits {
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
        max_buffer_size: offered.max_buffer_size,
        max_texture_dimension_2d: offered.max_texture_dimension_2d,
        max_texture_array_layers: offered.max_texture_array_layers,
        ..wgpu::Limits::default()
    }
}
