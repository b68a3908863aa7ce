//! A window's surface and a device that draws to it.

use std::sync::Arc;

use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

use path_tracer::renderer::Result;

/// A surface with its device.
pub(super) struct Screen {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) config: wgpu::SurfaceConfiguration,
    surface: wgpu::Surface<'static>,
}

impl Screen {
    /// Opens the fastest kind of adapter for this window, among those whose name contains `wanted`.
    ///
    /// # Errors
    /// If no such adapter can draw to the window, or opening its device fails.
    pub(super) fn open(
        display: OwnedDisplayHandle,
        window: Arc<Window>,
        wanted: Option<&str>,
    ) -> Result<Self> {
        let display = Box::new(display);
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle(display);
        let instance = wgpu::Instance::new(descriptor);
        let size = window.inner_size();
        let surface = instance.create_surface(window)?;
        let adapter = choose(&instance, &surface, wanted)?;
        // These features make wgdenoise faster; neither it nor the renderer requires them.
        let (device, queue) =
            pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
                label: Some("path tracer"),
                required_features: wgdenoise::required_features(&adapter),
                required_limits: wgdenoise::required_limits(&adapter),
                ..Default::default()
            }))?;
        let config = configuration(&surface, &adapter, [size.width, size.height])
            .ok_or("the adapter cannot draw to this window")?;
        surface.configure(&device, &config);
        Ok(Self { device, queue, config, surface })
    }

    pub(super) fn resize(&mut self, [width, height]: [u32; 2]) {
        self.config.width = width;
        self.config.height = height;
        self.surface.configure(&self.device, &self.config);
    }

    /// The texture for the next frame; `None` to skip this one.
    ///
    /// # Errors
    /// If the surface is invalid.
    pub(super) fn next(&self) -> Result<Option<wgpu::SurfaceTexture>> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Ok(Some(texture)),
            Current::Timeout | Current::Occluded => Ok(None),
            Current::Outdated | Current::Lost => {
                self.surface.configure(&self.device, &self.config);
                Ok(None)
            }
            Current::Validation => Err("the window's surface is invalid".into()),
        }
    }
}

/// Prefers discrete GPUs, then integrated and virtual ones, then CPU drivers.
fn choose(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'_>,
    wanted: Option<&str>,
) -> Result<wgpu::Adapter> {
    let wanted = wanted.unwrap_or_default().to_lowercase();
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let usable = adapters.into_iter().filter(|adapter| {
        adapter.is_surface_supported(surface)
            && adapter.get_info().name.to_lowercase().contains(&wanted)
    });
    let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
        wgpu::DeviceType::Cpu => 3,
    };
    let none = || format!("no adapter with `{wanted}` in its name can draw to a window");
    Ok(usable.min_by_key(rank).ok_or_else(none)?)
}

/// The surface's configuration, in an sRGB format where possible.
fn configuration(
    surface: &wgpu::Surface<'_>,
    adapter: &wgpu::Adapter,
    [width, height]: [u32; 2],
) -> Option<wgpu::SurfaceConfiguration> {
    let mut config = surface.get_default_config(adapter, width.max(1), height.max(1))?;
    let formats = surface.get_capabilities(adapter).formats;
    config.format = formats.into_iter().find(wgpu::TextureFormat::is_srgb).unwrap_or(config.format);
    config.present_mode = wgpu::PresentMode::AutoNoVsync;
    Some(config)
}
