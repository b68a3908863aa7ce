//! The workspace's only unsafe code, apart from a Vulkan layer that the command line's tests
//! compile (`crates/cli/tests/cli/faults/layer.rs`).
#![allow(unsafe_code, reason = "each call explains why no safe way exists and why it is sound")]

use super::compiled::Compiled;

/// Sets an environment variable for C libraries unless it is already set. Does nothing if the
/// process has several threads, or if their number is unknown, as on any system but Linux.
///
/// Std offers no safe way to do this.
pub(crate) fn set_variable_early(name: &str, value: &str) {
    let threads = std::fs::read_dir("/proc/self/task").map(Iterator::count);
    if matches!(threads, Ok(1)) && std::env::var_os(name).is_none() {
        // SAFETY: this is the only thread of the process, so no other thread reads the environment
        // meanwhile.
        unsafe { std::env::set_var(name, value) };
    }
}

/// A pipeline cache initialized from an earlier run's data, if any. The device must have the
/// feature `PIPELINE_CACHE`. wgpu has no safe way to return compiled data to a driver.
pub(crate) fn pipeline_cache(
    device: &wgpu::Device,
    compiled: Option<&Compiled<'_>>,
) -> wgpu::PipelineCache {
    let descriptor = wgpu::PipelineCacheDescriptor {
        label: Some("wgdenoise"),
        data: compiled.map(Compiled::data),
        fallback: true,
    };
    // SAFETY: a `Compiled` holds only bytes whose header names this crate, its version, the adapter
    // and the driver, and whose length and checksum match, so `PipelineCache::get_data` returned
    // them. Anyone able to forge all that can write the program's own files and needs no driver to
    // do harm.
    unsafe { device.create_pipeline_cache(&descriptor) }
}

/// The consent that wgpu demands for experimental features, which may have bugs. Cooperative
/// matrices are the only ones this crate uses.
pub(crate) fn consent_to(features: wgpu::Features) -> wgpu::ExperimentalFeatures {
    if features.contains(wgpu::Features::EXPERIMENTAL_COOPERATIVE_MATRIX) {
        // SAFETY: cooperative matrices are used only in defined ways. Matrices are loaded and
        // stored inside their arrays, by whole subgroups, in shapes that the adapter reports, and
        // the matrix kernels run only after a comparison with the CPU on the same device.
        unsafe { wgpu::ExperimentalFeatures::enabled() }
    } else {
        wgpu::ExperimentalFeatures::disabled()
    }
}
