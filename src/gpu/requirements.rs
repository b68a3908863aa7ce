//! Features and limits to request from an adapter.

use super::matrix_shape::MatrixShape;
use super::precision::Precision;

/// What to ask this adapter for: the features of this list that it has. None is needed.
///
/// | feature | what for | without it |
/// |---|---|---|
/// | `SUBGROUP` | the kernels for CPU drivers | CPU drivers run the slower tiled kernels; GPUs do not use it |
/// | `TIMESTAMP_QUERY` | [`Denoiser::profile`](crate::Denoiser::profile) on GPUs | the profile is an error; on CPU drivers it goes by the clock |
/// | `PIPELINE_CACHE` | [`Options::pipeline_cache`](crate::Options::pipeline_cache), on Vulkan | kernels are compiled anew in every run, unless the driver keeps them |
#[must_use]
pub fn required_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    use wgpu::Features;
    adapter.features() & (Features::SUBGROUP | Features::TIMESTAMP_QUERY | Features::PIPELINE_CACHE)
}

/// Features that the matrix kernels need on top, none where the adapter has no matrices that fit.
/// They are experimental in wgpu: who asks for them has to fill
/// `DeviceDescriptor::experimental_features`, which takes an `unsafe` block of the caller's.
#[must_use]
pub fn matrix_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    let shapes = [Precision::F32, Precision::F16].map(|p| MatrixShape::of(adapter, p));
    let features = shapes.into_iter().flatten().map(MatrixShape::features);
    features.fold(wgpu::Features::empty(), |all, one| all | one)
}

/// What to ask this adapter for: WebGPU's default limits, some of them raised to the adapter's. A
/// device with the default limits will do.
///
/// | limit | what for | with the default |
/// |---|---|---|
/// | `max_storage_buffer_binding_size`, `max_buffer_size` | images in buffers, and tiles of the blocking call | 128 MiB: images of up to 11 Mpixel of RGB in 32 bits, smaller tiles |
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
