//! Turns errors that a device reports into errors of this crate.

use crate::error::{Error, Result};

/// Runs `work` and turns errors that the device reports meanwhile on this thread into an error,
/// where wgpu would otherwise panic. A lost device, now or earlier, is an error too.
pub(crate) fn catch<T>(device: &wgpu::Device, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let filters = [
        wgpu::ErrorFilter::Validation,
        wgpu::ErrorFilter::OutOfMemory,
        wgpu::ErrorFilter::Internal,
    ];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let result = work();
    let reports = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
    // Every scope must be popped, so collect all reports before taking the first.
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

/// Whether the device is lost. wgpu reports a loss only through a device's single callback, which
/// belongs to the host. But a lost device reports no other errors, not even for a buffer without
/// usages.
fn is_lost(device: &wgpu::Device) -> bool {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let _ = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("refused by every working device"),
        size: 4,
        usage: wgpu::BufferUsages::empty(),
        mapped_at_creation: false,
    });
    pollster::block_on(scope.pop()).is_none()
}
