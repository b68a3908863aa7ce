//! How the window asks for its device, so that the denoiser is fast on it.

use std::sync::Arc;

use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use wgdenoise::wgpu;

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
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() }
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
