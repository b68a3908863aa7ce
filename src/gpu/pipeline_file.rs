//! Compiled kernels as bytes to keep between runs.

use wgpu::util::pipeline_cache_key;
use wgpu::{AdapterInfo, Device, Features, PipelineCache};

use super::compiled::Compiled;
use super::scopes::catch;
use super::unsafe_calls;

/// The file in which a program keeps a driver's compiled kernels, for [`Options::pipeline_cache`].
///
/// A header comes first: this crate's version, the adapter, its driver, and the length and 64-bit
/// FNV-1a hash of the data. Bytes with a mismatching header are ignored.
///
/// [`Options::pipeline_cache`]: crate::Options::pipeline_cache
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PipelineFile {
    name: String,
    key: String,
}

impl PipelineFile {
    /// An adapter's file; `None` if wgpu cannot cache pipelines on its backend (all but Vulkan).
    #[must_use]
    pub fn of(adapter: &AdapterInfo) -> Option<Self> {
        let name = pipeline_cache_key(adapter)?;
        let (driver, version) = (&adapter.driver, env!("CARGO_PKG_VERSION"));
        let key = format!("{name}; {driver}; {}; wgdenoise {version}", adapter.driver_info);
        Some(Self { name, key })
    }

    /// A file name unique to the adapter.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A cache initialized from `bytes`, or empty if they are damaged or from another driver or
    /// version. `None` if the device lacks the feature `PIPELINE_CACHE` or fails.
    #[must_use]
    pub fn load(&self, device: &Device, bytes: &[u8]) -> Option<PipelineCache> {
        if !device.features().contains(Features::PIPELINE_CACHE) {
            return None;
        }
        let compiled = Compiled::open(&self.key, bytes);
        catch(device, || Ok(unsafe_calls::pipeline_cache(device, compiled.as_ref()))).ok()
    }

    /// The bytes to keep; `None` if the driver returns none.
    #[must_use]
    pub fn save(&self, cache: &PipelineCache) -> Option<Vec<u8>> {
        Some(Compiled::seal(&self.key, &cache.get_data()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::{Backend, DeviceType};

    #[test]
    fn drivers_share_a_name_but_no_bytes_and_other_backends_have_none() {
        let info = |backend, driver_info: &str| {
            let info = AdapterInfo::new(DeviceType::DiscreteGpu, backend);
            AdapterInfo { driver_info: driver_info.into(), ..info }
        };
        let [old, new] = ["1.0", "1.1"].map(|driver| {
            PipelineFile::of(&info(Backend::Vulkan, driver)).expect("Vulkan has one")
        });
        assert_eq!(old.name(), new.name());
        assert_ne!(old.key, new.key);
        assert_eq!(PipelineFile::of(&info(Backend::Metal, "1.0")), None);
    }
}
