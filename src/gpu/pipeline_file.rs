//! Compiled kernels as bytes that a program keeps from run to run.

use wgpu::util::pipeline_cache_key;
use wgpu::{AdapterInfo, Device, Features, PipelineCache};

use super::scopes::catch;
use crate::unsafe_calls;

/// The file in which a program keeps what a driver compiled, for [`Options::pipeline_cache`].
///
/// The bytes begin with a header: this crate's version, the adapter, its driver, and the length and
/// 64-bit FNV-1a hash of what follows. Bytes whose header does not match are ignored.
///
/// [`Options::pipeline_cache`]: crate::Options::pipeline_cache
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PipelineFile {
    name: String,
    key: String,
}

impl PipelineFile {
    /// The file of an adapter; `None` where wgpu keeps no pipelines for its backend (all but Vulkan).
    #[must_use]
    pub fn of(adapter: &AdapterInfo) -> Option<Self> {
        let name = pipeline_cache_key(adapter)?;
        let (driver, version) = (&adapter.driver, env!("CARGO_PKG_VERSION"));
        let key = format!("{name}; {driver}; {}; wgdenoise {version}", adapter.driver_info);
        Some(Self { name, key })
    }

    /// A file name that is unique to the adapter.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A cache that begins with what `bytes` hold, or empty if they are damaged or of another driver
    /// or version. `None` if the device lacks the feature `PIPELINE_CACHE` or fails.
    #[must_use]
    pub fn load(&self, device: &Device, bytes: &[u8]) -> Option<PipelineCache> {
        if !device.features().contains(Features::PIPELINE_CACHE) {
            return None;
        }
        let compiled = self.open(bytes);
        catch(device, || Ok(unsafe_calls::pipeline_cache(device, compiled.as_ref()))).ok()
    }

    /// The bytes to keep; `None` if the driver gives none.
    #[must_use]
    pub fn save(&self, cache: &PipelineCache) -> Option<Vec<u8>> {
        Some(self.seal(&cache.get_data()?))
    }

    fn seal(&self, data: &[u8]) -> Vec<u8> {
        [&header(&self.key, data), data].concat()
    }

    fn open<'a>(&self, bytes: &'a [u8]) -> Option<Compiled<'a>> {
        // The header's length does not depend on the data.
        let data = bytes.get(header(&self.key, &[]).len()..)?;
        bytes.starts_with(&header(&self.key, data)).then_some(Compiled(data))
    }
}

/// What [`PipelineCache::get_data`] gave for the same driver, as far as a checksum can tell.
pub(crate) struct Compiled<'a>(&'a [u8]);

impl<'a> Compiled<'a> {
    pub(crate) fn data(&self) -> &'a [u8] {
        self.0
    }
}

fn header(key: &str, data: &[u8]) -> Vec<u8> {
    let (length, hash) = (data.len(), fnv1a(data));
    format!("wgdenoise pipelines\n{key}\n{length:016x} {hash:016x}\n").into_bytes()
}

/// Every step is a bijection, so that one changed byte always changes the hash.
fn fnv1a(data: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    data.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::{Backend, DeviceType};

    const DATA: &[u8] = b"\0compiled\n\xff";

    fn info(driver_info: &str) -> AdapterInfo {
        let info = AdapterInfo::new(DeviceType::DiscreteGpu, Backend::Vulkan);
        AdapterInfo { driver_info: driver_info.into(), ..info }
    }

    fn file(driver_info: &str) -> PipelineFile {
        PipelineFile::of(&info(driver_info)).expect("Vulkan has one")
    }

    fn opened(file: &PipelineFile, bytes: &[u8]) -> Option<Vec<u8>> {
        file.open(bytes).map(|compiled| compiled.data().to_vec())
    }

    #[test]
    fn bytes_are_read_for_the_same_driver_alone() {
        let (old, new) = (file("1.0"), file("1.1"));
        assert_eq!(old.name(), new.name());
        let bytes = old.seal(DATA);
        assert_eq!((opened(&old, &bytes).as_deref(), opened(&new, &bytes)), (Some(DATA), None));
        assert_eq!(opened(&old, &old.seal(b"")).as_deref(), Some(&b""[..]));
        assert_eq!(PipelineFile::of(&AdapterInfo { backend: Backend::Metal, ..info("") }), None);
    }

    #[test]
    fn damaged_bytes_are_ignored() {
        let file = file("1.0");
        let whole = file.seal(DATA);
        let cut = (0..whole.len()).map(|end| whole[..end].to_vec());
        let flipped = (0..whole.len()).map(|at| {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            bytes
        });
        let longer = [&whole[..], b"\0"].concat();
        for damaged in cut.chain(flipped).chain([longer, DATA.to_vec(), b"WGPUPLCH".to_vec()]) {
            assert_eq!(opened(&file, &damaged), None, "{damaged:?}");
        }
    }
}
