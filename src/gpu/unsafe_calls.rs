//! The only unsafe code of the workspace, but for a Vulkan layer that tests of the command line
//! compile (`crates/cli/tests/cli/faults/layer.rs`).
#![allow(unsafe_code, reason = "each call says why no safe way exists and why it is sound")]

use super::compiled::Compiled;

/// Sets an environment variable that C libraries read, unless it is set; `false` if the process has
/// several threads or their number is unknown, which is so on all systems but Linux.
///
/// Std offers no safe way to do this.
pub(crate) fn set_variable_early(name: &str, value: &str) -> bool {
    let threads = std::fs::read_dir("/proc/self/task").map(Iterator::count);
    if !matches!(threads, Ok(1)) {
        return false;
    }
    if std::env::var_os(name).is_none() {
        // SAFETY: the calling thread is the only one of the process, so that none reads the
        // environment meanwhile.
        unsafe { std::env::set_var(name, value) };
    }
    true
}

/// A cache of compiled pipelines that begins with what an earlier run left, if anything.
/// The device must have the feature `PIPELINE_CACHE`. wgpu has no safe way to hand a driver what it
/// compiled before.
pub(crate) fn pipeline_cache(
    device: &wgpu::Device,
    compiled: Option<&Compiled<'_>>,
) -> wgpu::PipelineCache {
    let descriptor = wgpu::PipelineCacheDescriptor {
        label: Some("wgdenoise"),
        data: compiled.map(Compiled::data),
        fallback: true,
    };
    // SAFETY: `Compiled` is made only of bytes whose header names this crate, its version, the
    // adapter and the driver, and whose length and checksum match: the data is what
    // `PipelineCache::get_data` gave. Whoever can forge all of that can write to the program's own
    // files, and needs no driver to do harm.
    unsafe { device.create_pipeline_cache(&descriptor) }
}

/// Consent to the experimental features among `features`, which wgpu demands for features that may
/// have bugs. Cooperative matrices are the only ones that this crate uses.
pub(crate) fn consent_to(features: wgpu::Features) -> wgpu::ExperimentalFeatures {
    if features.contains(wgpu::Features::EXPERIMENTAL_COOPERATIVE_MATRIX) {
        // SAFETY: nothing that is undefined of cooperative matrices happens: tiles are loaded
        // and stored inside their arrays, by whole subgroups, in shapes that the adapter reports,
        // and the matrix kernels run only after a comparison with the CPU on the same device.
        unsafe { wgpu::ExperimentalFeatures::enabled() }
    } else {
        wgpu::ExperimentalFeatures::disabled()
    }
}
