//! The user's cache folder, which keeps the kernels that drivers compiled to speed up the next run.
//! A missing or damaged file costs time but is not a failure.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;

use wgdenoise::wgpu::{AdapterInfo, PipelineCache};
use wgdenoise::{Gpu, Options, PipelineFile};
use wgdenoise_files::{Out, Problem};

/// `wgdenoise` in the system's folder for caches; `None` if the user has no home.
pub(crate) fn folder_of_user() -> Option<PathBuf> {
    let folders = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(folders.cache_dir().join("wgdenoise"))
}

/// Replaces a file as a whole, so that other processes see either the old or the new one. Creates
/// its folder first.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let write = |out: &mut Out<'_>| out.write_all(bytes).map_err(Problem::Write);
    wgdenoise_files::replace(path, true, write).map_err(|error| error.to_string())
}

/// A longer file is not read, and so gets replaced: drivers only ever add to what they were given.
const MAX_BYTES: u64 = 64 << 20;

/// The compiled kernels of one adapter.
struct Pipelines {
    path: PathBuf,
    file: PipelineFile,
}

impl Pipelines {
    /// `None` if wgpu keeps nothing for the adapter's backend or the user has no home.
    fn of_user(info: &AdapterInfo) -> Option<Self> {
        Self::within(&folder_of_user()?, info)
    }

    fn within(folder: &Path, info: &AdapterInfo) -> Option<Self> {
        let file = PipelineFile::of(info)?;
        Some(Self { path: folder.join(file.name()), file })
    }

    /// Reads what an earlier run left; empty if there is nothing, or too much.
    fn read(&self) -> Vec<u8> {
        let short = |metadata: &fs::Metadata| metadata.is_file() && metadata.len() <= MAX_BYTES;
        let found = fs::metadata(&self.path).ok().filter(short);
        found.and_then(|_| fs::read(&self.path).ok()).unwrap_or_default()
    }

    /// Creates a cache that starts with the file's contents.
    fn cache(&self, Gpu { device, .. }: &Gpu) -> Option<PipelineCache> {
        self.file.load(device, &self.read())
    }

    /// Replaces the file if its contents differ.
    fn write(&self, bytes: &[u8]) -> Result<(), String> {
        if self.read() == bytes { Ok(()) } else { write(&self.path, bytes) }
    }
}

/// Creates a cache for the adapter's kernels, with what earlier runs left; `None` where caching is
/// not possible.
pub(crate) fn pipelines(gpu: &Gpu) -> Option<PipelineCache> {
    Pipelines::of_user(&gpu.info)?.cache(gpu)
}

/// Saves the options' cache for the next run. If that fails, the next run compiles again, so no
/// notice is given.
pub(crate) fn keep_pipelines(gpu: &Gpu, options: &Options) {
    let bytes = |store: &Pipelines| store.file.save(options.pipeline_cache.as_ref()?);
    if let Some(store) = Pipelines::of_user(&gpu.info)
        && let Some(bytes) = bytes(&store)
    {
        let _ = store.write(&bytes);
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::{Duration, SystemTime};

    use super::*;
    use wgdenoise::wgpu::{Backend, DeviceType};
    use wgdenoise::{Denoiser, Quality, Weights};

    const BYTES: &[u8] = b"\0compiled\n\xff";

    fn store(folder: &Path) -> Pipelines {
        let info = AdapterInfo::new(DeviceType::DiscreteGpu, Backend::Vulkan);
        Pipelines::within(folder, &info).expect("Vulkan has one")
    }

    #[test]
    fn what_was_written_is_read_and_its_folder_is_created() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(&folder.path().join("not/yet"));
        assert_eq!(store.read(), b"");
        store.write(BYTES).unwrap();
        assert_eq!(store.read(), BYTES);
    }

    #[test]
    fn a_file_that_has_grown_too_long_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path());
        store.write(&vec![7; MAX_BYTES as usize + 1]).unwrap();
        assert_eq!(store.read(), b"");
        store.write(BYTES).unwrap();
        assert_eq!(store.read(), BYTES);
    }

    #[test]
    fn only_what_has_changed_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path());
        let changed = || fs::metadata(&store.path).unwrap().modified().unwrap();
        store.write(BYTES).unwrap();
        let long_ago = SystemTime::UNIX_EPOCH + Duration::from_secs(1);
        let file = fs::File::options().write(true).open(&store.path).unwrap();
        file.set_modified(long_ago).unwrap();
        store.write(BYTES).unwrap();
        assert_eq!(changed(), long_ago);
        store.write(b"more").unwrap();
        assert_ne!(changed(), long_ago);
    }

    #[test]
    fn a_reader_sees_what_one_of_many_writers_wrote() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path());
        let data = |i: u8| vec![i; 1000 + usize::from(i)];
        store.write(&data(0)).unwrap();
        thread::scope(|scope| {
            for i in 0..4 {
                let store = &store;
                scope.spawn(move || (0..20).for_each(|_| store.write(&data(i)).unwrap()));
            }
            for _ in 0..100 {
                let seen = store.read();
                assert_eq!(seen, data(seen[0]));
            }
        });
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_blocked_folder_and_a_blocked_file_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let blocked_file = store(folder.path());
        fs::create_dir_all(&blocked_file.path).unwrap();
        assert_eq!(blocked_file.read(), b"");
        blocked_file.write(BYTES).unwrap_err();
        fs::write(folder.path().join("file"), "").unwrap();
        let blocked = store(&folder.path().join("file"));
        assert_eq!(blocked.read(), b"");
        blocked.write(BYTES).unwrap_err();
    }

    #[test]
    fn the_adapter_accepts_what_it_compiled() {
        let folder = tempfile::tempdir().unwrap();
        let gpu = Gpu::open(None).expect("the tests need an adapter");
        let Some(store) = Pipelines::within(folder.path(), &gpu.info) else {
            assert_ne!(gpu.info.backend, Backend::Vulkan, "only other backends have none");
            return;
        };
        let compile = || {
            let cache = store.cache(&gpu).expect("Vulkan has one");
            let options = Options::default().pipeline_cache(cache.clone());
            let weights = Weights::builtin(Quality::Fast).unwrap();
            Denoiser::new(&gpu.device, &gpu.queue, &weights, &options).unwrap();
            store.file.save(&cache).expect("the device works")
        };
        let first = compile();
        store.write(&first).unwrap();
        assert_eq!(store.read(), first);
        assert!(compile().len() >= first.len());
    }
}
