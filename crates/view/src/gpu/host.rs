//! How the window asks for its device, so that the denoiser is fast on it.

use std::sync::Arc;

use eframe::egui_wgpu::{
    RenderState, SurfaceErrorAction, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew,
};
use wgdenoise::wgpu::{self, CurrentSurfaceTexture};

/// What is needed to compute on the window's device.
#[derive(Clone, Debug)]
pub(crate) struct Gpu {
    pub(crate) adapter: wgpu::Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

impl Gpu {
    pub(crate) fn of(state: &RenderState) -> Self {
        let RenderState { adapter, device, queue, .. } = state.clone();
        // wgpu panics by default. Resizing the window waits for the device, but not for long: while
        // a slow one denoises, that fails, and the next frame tries again. The denoiser catches its
        // own errors.
        device.on_uncaptured_error(Arc::new(|error| eprintln!("wgdenoise-view: {error}")));
        Self { adapter, device, queue }
    }
}

/// A window on the fastest adapter, with the features and limits that the denoiser uses.
pub(crate) fn configuration() -> WgpuConfiguration {
    let setup = WgpuSetupCreateNew {
        power_preference: wgpu::PowerPreference::HighPerformance,
        device_descriptor: Arc::new(descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    let wgpu_setup = WgpuSetup::CreateNew(setup);
    WgpuConfiguration { wgpu_setup, on_surface_status: Arc::new(action), ..Default::default() }
}

/// What to do about a frame that has no texture.
fn action(status: &CurrentSurfaceTexture) -> SurfaceErrorAction {
    match status {
        // After a failure to resize, the surface has no size until it is configured again.
        CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => {
            SurfaceErrorAction::Reconfigure
        }
        CurrentSurfaceTexture::Lost => SurfaceErrorAction::RecreateSurface,
        _ => SurfaceErrorAction::SkipFrame,
    }
}

fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("wgdenoise-view"),
        required_features: wgdenoise::required_features(adapter),
        required_limits: wgdenoise::required_limits(adapter),
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        ..Default::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_that_could_not_be_resized_is_configured_by_the_next_frame() {
        for status in [CurrentSurfaceTexture::Outdated, CurrentSurfaceTexture::Validation] {
            assert!(matches!(action(&status), SurfaceErrorAction::Reconfigure), "{status:?}");
        }
        assert!(matches!(action(&CurrentSurfaceTexture::Timeout), SurfaceErrorAction::SkipFrame));
    }
}
