//! Requests the window's device so that the denoiser runs fast on it.

use std::sync::{Arc, OnceLock};

use eframe::egui_wgpu::{
    RenderState, SurfaceErrorAction, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew,
};
use wgdenoise::wgpu::{self, CurrentSurfaceTexture, DeviceType};

use crate::gpu::levels::Levels;

/// Everything needed to compute on the window's device.
#[derive(Clone, Debug)]
pub(crate) struct Gpu {
    pub(crate) adapter: wgpu::Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Compiled by the first thread that needs them, so the window does not wait.
    levels: Arc<OnceLock<Levels>>,
}

impl Gpu {
    pub(crate) fn of(state: &RenderState) -> Self {
        let RenderState { adapter, device, queue, .. } = state.clone();
        // By default, wgpu panics. Resizing the window waits for the device, but with a timeout:
        // while a slow device denoises, the resize fails, and the next frame tries again. The
        // denoiser catches its own errors.
        device.on_uncaptured_error(Arc::new(|error| eprintln!("wgdenoise-view: {error}")));
        Self { adapter, device, queue, levels: Arc::default() }
    }

    /// The kernels that fill textures.
    pub(crate) fn levels(&self) -> &Levels {
        self.levels.get_or_init(|| Levels::new(&self.device, &self.queue))
    }

    /// The device to denoise on: the window's, so that results stay on the GPU, unless it is a CPU
    /// driver. A CPU driver runs a device's commands one after the other, so the window would wait
    /// for every layer of the network; with two devices, they share the cores.
    pub(crate) fn for_denoiser(&self) -> Self {
        if self.adapter.get_info().device_type != DeviceType::Cpu {
            return self.clone();
        }
        let request = self.adapter.request_device(&descriptor(&self.adapter));
        match pollster::block_on(request) {
            Ok((device, queue)) => {
                Self { device, queue, adapter: self.adapter.clone(), levels: Arc::default() }
            }
            // Sluggish to watch, but correct.
            Err(_) => self.clone(),
        }
    }

    #[cfg(test)]
    pub(crate) fn for_tests() -> Self {
        let wgdenoise::Gpu { adapter, device, queue, .. } =
            wgdenoise::Gpu::open(None).expect("the tests need an adapter");
        Self { adapter, device, queue, levels: Arc::default() }
    }
}

/// Configures a window on the fastest adapter, with the features and limits that the denoiser uses.
pub(crate) fn configuration() -> WgpuConfiguration {
    let setup = WgpuSetupCreateNew {
        power_preference: wgpu::PowerPreference::HighPerformance,
        device_descriptor: Arc::new(descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    let wgpu_setup = WgpuSetup::CreateNew(setup);
    WgpuConfiguration { wgpu_setup, on_surface_status: Arc::new(action), ..Default::default() }
}

/// Decides what to do about a frame without a texture.
fn action(status: &CurrentSurfaceTexture) -> SurfaceErrorAction {
    match status {
        // After a failed resize, the surface has no size until it is reconfigured.
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
