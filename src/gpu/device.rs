//! This machine's adapters, for programs without a device of their own. A renderer that embeds
//! wgdenoise brings its own device and never needs this module.

use super::unsafe_calls::{consent_to, set_variable_early};
use crate::error::{Error, Result};

/// A device with every feature and limit that its adapter's fastest kernels can use.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter's description of itself.
    pub info: wgpu::AdapterInfo,
    /// The adapter. Only it knows its [`MatrixShape`](crate::MatrixShape).
    pub adapter: wgpu::Adapter,
}

impl Gpu {
    /// All adapters of this machine, in the order of [`Gpu::open`]'s indices.
    #[must_use]
    pub fn list() -> Vec<wgpu::AdapterInfo> {
        adapters().iter().map(wgpu::Adapter::get_info).collect()
    }

    /// Opens an adapter by its index in [`Gpu::list`] or by part of its name, ignoring case. `None`
    /// picks the best kind available: discrete, integrated, virtual, then a CPU driver.
    ///
    /// # Errors
    /// Fails if the machine has no adapter, none matches `selector`, or the adapter fails to open a
    /// device.
    pub fn open(selector: Option<&str>) -> Result<Self> {
        let adapters = adapters();
        if adapters.is_empty() {
            return Err(Error::NoAdapter(NO_ADAPTER.into()));
        }
        let index = choose(&names(&adapters), selector)?;
        Self::request(&adapters[index])
    }

    /// Silences Mesa's device-select layer, which reorders adapters for desktops and complains on
    /// stderr where no desktop session runs. Sets `NODEVICE_SELECT=1` unless it is already set.
    /// Call it before the process starts a second thread; later, and on systems other than Linux,
    /// it does nothing.
    pub fn silence_device_select() {
        set_variable_early("NODEVICE_SELECT", "1");
    }

    fn request(adapter: &wgpu::Adapter) -> Result<Self> {
        let usual = crate::required_features(adapter);
        // A driver may refuse an experimental feature that it advertises.
        Self::request_with(adapter, usual | crate::matrix_features(adapter))
            .or_else(|_| Self::request_with(adapter, usual))
    }

    fn request_with(adapter: &wgpu::Adapter, required_features: wgpu::Features) -> Result<Self> {
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("wgdenoise"),
            required_features,
            required_limits: crate::required_limits(adapter),
            experimental_features: consent_to(required_features),
            // Allocate in small blocks, so that little memory is held beyond what is used.
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                Error::NoAdapter(format!("`{}` failed to open a device: {e}", info.name))
            })?;
        Ok(Self { device, queue, info, adapter: adapter.clone() })
    }
}

const NO_ADAPTER: &str = "found no Vulkan, Metal or DX12 adapter; install the driver of the \
    graphics card, or a CPU driver such as lavapipe (Debian and Ubuntu: `apt install \
    mesa-vulkan-drivers`)";

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    found.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    found
}

fn rank(device_type: wgpu::DeviceType) -> u8 {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
        wgpu::DeviceType::Cpu => 3,
    }
}

fn names(adapters: &[wgpu::Adapter]) -> Vec<String> {
    adapters.iter().map(|adapter| adapter.get_info().name).collect()
}

fn choose(names: &[String], selector: Option<&str>) -> Result<usize> {
    let Some(wanted) = selector else { return Ok(0) };
    // A number is always an index: `7` must not match "RTX 4070".
    let found = match wanted.parse::<usize>() {
        Ok(index) => (index < names.len()).then_some(index),
        Err(_) if wanted.is_empty() => None,
        Err(_) => names.iter().position(|n| n.to_lowercase().contains(&wanted.to_lowercase())),
    };
    found.ok_or_else(|| {
        let listed: Vec<_> = names.iter().enumerate().map(|(i, n)| format!("{i}: {n}")).collect();
        Error::NoAdapter(format!(
            "`{wanted}` matches none of the adapters here ({}); give an index or part of a \
             name, or install the driver of the one you want (for the CPU driver lavapipe on \
             Debian and Ubuntu: `apt install mesa-vulkan-drivers`)",
            listed.join(", ")
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_is_chosen_by_index_by_name_or_by_rank() {
        let names = ["Quick GPU 77".to_string(), "llvmpipe".to_string()];
        assert_eq!(choose(&names, None).unwrap(), 0);
        assert_eq!(choose(&names, Some("1")).unwrap(), 1);
        assert_eq!(choose(&names, Some("LLVM")).unwrap(), 1);
        choose(&names, Some("")).unwrap_err();
        let error = choose(&names, Some("7")).unwrap_err().to_string();
        assert!(error.contains("1: llvmpipe") && error.contains("mesa-vulkan-drivers"));
    }
}
