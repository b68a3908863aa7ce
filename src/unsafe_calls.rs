//! The only unsafe code but for a Vulkan layer that the tests compile (`tests/cli/faults/layer.rs`).
#![allow(unsafe_code, reason = "each call says below why no safe way exists and why it is sound")]

#[cfg(feature = "cli")]
use crate::cli::pipelines::Left;

/// Without a desktop session, Mesa's device-select layer prints "error: XDG_RUNTIME_DIR is invalid"
/// and goes on. Its order of devices is not used here, so the layer is switched off, unless the
/// user has said something about it. Std offers no safe way to set a variable for libraries of C.
///
/// To be called before anything else, while the program has one thread.
#[cfg(feature = "cli")]
pub(crate) fn silence_loader() {
    if std::env::var_os("NODEVICE_SELECT").is_none() {
        // SAFETY: no other thread exists yet that could read the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// A cache of compiled pipelines that begins with what an earlier run left, if that is known.
/// The device has the feature `PIPELINE_CACHE`. Std and wgpu have no safe way to hand a driver
/// what it compiled before.
#[cfg(feature = "cli")]
pub(crate) fn pipeline_cache(device: &wgpu::Device, left: Option<&Left>) -> wgpu::PipelineCache {
    let descriptor = wgpu::PipelineCacheDescriptor {
        label: Some("wgdenoise"),
        data: left.map(Left::data),
        fallback: true,
    };
    // SAFETY: `Left` is made from nothing but a file whose header names this program, its version,
    // the adapter and the driver, and whose length and checksum are those that were written with
    // it: the data is what `PipelineCache::get_data` gave then. Who forges all of it can write to
    // the user's own folders, and needs no driver to do harm.
    unsafe { device.create_pipeline_cache(&descriptor) }
}

/// Leave to ask an adapter for `features`: wgpu wants to hear of experimental ones that its user
/// knows that they may have bugs. Cooperative matrices are the only ones that this crate uses.
pub(crate) fn leave_for(features: wgpu::Features) -> wgpu::ExperimentalFeatures {
    if features.contains(wgpu::Features::EXPERIMENTAL_COOPERATIVE_MATRIX) {
        // SAFETY: what is undefined of cooperative matrices does not happen: tiles are loaded
        // and stored inside of their arrays, by whole subgroups, in shapes that the adapter
        // reports, and a device uses them only after its results were held against the CPU's.
        unsafe { wgpu::ExperimentalFeatures::enabled() }
    } else {
        wgpu::ExperimentalFeatures::disabled()
    }
}
