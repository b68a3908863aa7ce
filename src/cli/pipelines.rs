//! Kernels as the driver compiled them, kept from run to run in a file of the user's cache folder.
//!
//! Whatever is wrong with the file or its folder, it is as if nothing had been kept.

use std::fs;
use std::path::{Path, PathBuf};

use super::cache;
use crate::requirements::catch;
use crate::wgpu::util::pipeline_cache_key;
use crate::wgpu::{AdapterInfo, Features, PipelineCache};
use crate::{Gpu, Options, unsafe_calls};

/// A longer file is not read, and so begun anew: drivers only ever add to what they were given.
const MAX_BYTES: u64 = 64 << 20;

/// What an earlier run left in its file: data of the driver's, as long as its header holds.
pub(crate) struct Left {
    file: Vec<u8>,
    begin: usize,
}

impl Left {
    /// `None` if the file is damaged, not of this program's version or for another driver.
    fn of(file: Vec<u8>, key: &str) -> Option<Self> {
        // The header's length does not depend on the data.
        let begin = header(key, &[]).len();
        let data = file.get(begin..)?;
        file.starts_with(&header(key, data)).then_some(Self { file, begin })
    }

    /// What [`PipelineCache::get_data`] gave.
    pub(crate) fn data(&self) -> &[u8] {
        &self.file[self.begin..]
    }
}

/// What must be as it was when the file was written: who wrote it, for which driver, and the
/// length and checksum of what follows.
fn header(key: &str, data: &[u8]) -> Vec<u8> {
    let (length, checksum) = (data.len(), crc32fast::hash(data));
    format!("wgdenoise pipelines\n{key}\n{length:016x} {checksum:08x}\n").into_bytes()
}

/// The file of an adapter.
struct Store {
    path: PathBuf,
    key: String,
}

impl Store {
    /// `None` if wgpu keeps nothing for the adapter's backend or the user has no home.
    fn of_user(info: &AdapterInfo) -> Option<Self> {
        Self::within(&cache::folder_of_user()?, info)
    }

    fn within(folder: &Path, info: &AdapterInfo) -> Option<Self> {
        let name = pipeline_cache_key(info)?;
        let (driver, version) = (&info.driver, env!("CARGO_PKG_VERSION"));
        let key = format!("{name}; {driver}; {}; wgdenoise {version}", info.driver_info);
        Some(Self { path: folder.join(name), key })
    }

    fn read(&self) -> Option<Left> {
        let metadata = fs::metadata(&self.path).ok()?;
        if !metadata.is_file() || metadata.len() > MAX_BYTES {
            return None;
        }
        Left::of(fs::read(&self.path).ok()?, &self.key)
    }

    /// A cache that begins with what the file holds.
    fn cache(&self, Gpu { device, .. }: &Gpu) -> Option<PipelineCache> {
        if !device.features().contains(Features::PIPELINE_CACHE) {
            return None;
        }
        let left = self.read();
        catch(device, || Ok(unsafe_calls::pipeline_cache(device, left.as_ref()))).ok()
    }

    /// Replaces what the file holds if that is something else.
    fn write(&self, data: &[u8]) -> Result<(), String> {
        if self.read().is_some_and(|left| left.data() == data) {
            return Ok(());
        }
        cache::write(&self.path, &[&header(&self.key, data), data].concat())
    }
}

/// A cache for the adapter's kernels with what earlier runs left; `None` where it can have none.
pub(super) fn open(gpu: &Gpu) -> Option<PipelineCache> {
    Store::of_user(&gpu.info)?.cache(gpu)
}

/// Keeps what the options' cache holds for the next run. If that cannot be, the next run compiles
/// again, which nobody needs to be told.
pub(super) fn keep(gpu: &Gpu, options: &Options) {
    let data = options.pipeline_cache.as_ref().and_then(PipelineCache::get_data);
    if let (Some(store), Some(data)) = (Store::of_user(&gpu.info), data) {
        let _ = store.write(&data);
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::{Duration, SystemTime};

    use super::*;
    use crate::wgpu::{Backend, DeviceType};
    use crate::{Denoiser, Quality, Weights};

    const DATA: &[u8] = b"\0compiled\n\xff";

    fn info(driver_info: &str) -> AdapterInfo {
        let info = AdapterInfo::new(DeviceType::DiscreteGpu, Backend::Vulkan);
        AdapterInfo { driver_info: driver_info.into(), ..info }
    }

    fn store(folder: &tempfile::TempDir, driver_info: &str) -> Store {
        Store::within(&folder.path().join("not/yet"), &info(driver_info)).expect("Vulkan has one")
    }

    fn read(store: &Store) -> Option<Vec<u8>> {
        store.read().map(|left| left.data().to_vec())
    }

    #[test]
    fn what_was_written_is_read_for_the_same_driver_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (store(&folder, "1.0"), store(&folder, "1.1"));
        assert_eq!((read(&old), &old.path), (None, &new.path));
        old.write(DATA).unwrap();
        assert_eq!((read(&old).as_deref(), read(&new)), (Some(DATA), None));
        new.write(b"").unwrap();
        assert_eq!((read(&old), read(&new).as_deref()), (None, Some(&b""[..])));
        assert!(
            Store::within(folder.path(), &AdapterInfo { backend: Backend::Metal, ..info("") })
                .is_none()
        );
    }

    #[test]
    fn a_damaged_file_is_as_good_as_none_and_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder, "1.0");
        store.write(DATA).unwrap();
        let whole = fs::read(&store.path).unwrap();
        let cut = (0..whole.len()).map(|end| whole[..end].to_vec());
        let flipped = (0..whole.len()).map(|at| {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            bytes
        });
        let longer = [&whole[..], b"\0"].concat();
        for damaged in cut.chain(flipped).chain([longer, DATA.to_vec(), b"WGPUPLCH".to_vec()]) {
            fs::write(&store.path, &damaged).unwrap();
            assert_eq!(read(&store), None, "{damaged:?}");
        }
        store.write(DATA).unwrap();
        assert_eq!(fs::read(&store.path).unwrap(), whole);
    }

    #[test]
    fn a_file_that_has_grown_too_long_is_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder, "1.0");
        store.write(&vec![7; MAX_BYTES as usize]).unwrap();
        assert_eq!(read(&store), None);
        store.write(DATA).unwrap();
        assert_eq!(read(&store).as_deref(), Some(DATA));
    }

    #[test]
    fn only_what_has_changed_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder, "1.0");
        let changed = || fs::metadata(&store.path).unwrap().modified().unwrap();
        store.write(DATA).unwrap();
        let long_ago = SystemTime::UNIX_EPOCH + Duration::from_secs(1);
        let file = fs::File::options().write(true).open(&store.path).unwrap();
        file.set_modified(long_ago).unwrap();
        store.write(DATA).unwrap();
        assert_eq!(changed(), long_ago);
        store.write(b"more").unwrap();
        assert_ne!(changed(), long_ago);
    }

    #[test]
    fn a_reader_sees_what_one_of_many_writers_wrote() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder, "1.0");
        let data = |i: u8| vec![i; 1000 + usize::from(i)];
        store.write(&data(0)).unwrap();
        thread::scope(|scope| {
            for i in 0..4 {
                let store = &store;
                scope.spawn(move || (0..20).for_each(|_| store.write(&data(i)).unwrap()));
            }
            for _ in 0..100 {
                let seen = read(&store).expect("a whole file");
                assert_eq!(seen, data(seen[0]));
            }
        });
        assert_eq!(fs::read_dir(store.path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_that_cannot_be_made_and_a_file_that_is_none_are_said() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder, "1.0");
        fs::create_dir_all(&store.path).unwrap();
        assert_eq!(read(&store), None);
        store.write(DATA).unwrap_err();
        fs::write(folder.path().join("file"), "").unwrap();
        let blocked = Store::within(&folder.path().join("file"), &info("1.0")).unwrap();
        assert_eq!(read(&blocked), None);
        blocked.write(DATA).unwrap_err();
    }

    #[test]
    fn the_adapter_takes_what_it_gave() {
        let folder = tempfile::tempdir().unwrap();
        let gpu = Gpu::open(None).expect("the tests need an adapter");
        let Some(store) = Store::within(folder.path(), &gpu.info) else {
            assert_ne!(gpu.info.backend, Backend::Vulkan, "only other backends have none");
            return;
        };
        let compile = || {
            let pipeline_cache = store.cache(&gpu);
            let options = Options { pipeline_cache, ..Options::default() };
            let weights = Weights::builtin(Quality::Fast).unwrap();
            Denoiser::new(&gpu.device, &gpu.queue, &weights, &options).unwrap();
            options.pipeline_cache.expect("Vulkan has one").get_data().expect("the device works")
        };
        let first = compile();
        store.write(&first).unwrap();
        assert_eq!(read(&store), Some(first.clone()));
        assert!(compile().len() >= first.len());
    }
}
