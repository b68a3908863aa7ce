//! Errors that a device reports, as errors of this crate.

use crate::error::{Error, Result};

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
        report if is_lost(device) => Err(Error::DeviceLost { source: report }),
        Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory(
            "the adapter is out of memory; lower the memory budget or the tile size".into(),
        )),
        Some(report) => {
            Err(Error::Device { message: report.to_string(), source: Some(report.into()) })
        }
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
