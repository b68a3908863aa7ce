//! What to ask an adapter for, and errors of a device as errors of this crate.

use crate::error::{Error, Result};
use crate::ops::matrix::MatrixShape;
use crate::options::Precision;

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

/// Runs `work` and turns what the device reports meanwhile, on this thread, into an error
/// instead of the panic that wgpu would make of it. That the device is lost, now or before, is
/// an error as well.
pub(crate) fn catch<T>(device: &wgpu::Device, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let filters = [
        wgpu::ErrorFilter::Validation,
        wgpu::ErrorFilter::OutOfMemory,
        wgpu::ErrorFilter::Internal,
    ];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let result = work();
    let reports = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
    // Every scope must be popped, so all reports are collected before the first is taken.
    let reports: Vec<_> = reports.collect();
    match reports.into_iter().flatten().next() {
        report if is_lost(device) => Err(lost(report.as_ref())),
        Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::Memory(
            "the adapter is out of memory; lower the memory budget or the tile size".into(),
        )),
        Some(report) => Err(Error::Device(report.to_string())),
        None => result,
    }
}

/// Whether the device is lost. wgpu tells that to a callback, of which a device has one, and it is
/// the host's. But a lost device reports no other error any more, not even at a buffer for nothing.
fn is_lost(device: &wgpu::Device) -> bool {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let _ = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("refused by every device that works"),
        size: 4,
        usage: wgpu::BufferUsages::empty(),
        mapped_at_creation: false,
    });
    pollster::block_on(scope.pop()).is_none()
}

/// The error of a lost device, with what it reported last, if anything.
pub(crate) fn lost(report: Option<&wgpu::Error>) -> Error {
    let report = report.map(|report| format!(" ({report})")).unwrap_or_default();
    Error::Device(format!(
        "the device was lost{report}, as after a reset or an update of its driver, too long a \
         dispatch or the end of its memory; open it again, and if it is lost again, take smaller \
         tiles or another adapter"
    ))
}
