//! What is kept from run to run in files of the user's cache folder: here, measurements of adapters.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;
use serde_json::{Map, Value, json};

use wgdenoise::{Calibration, Cost, Quality};
use wgdenoise_files::Problem;

/// `wgdenoise` where the system keeps what can be made again; `None` if the user has no home.
pub(super) fn folder_of_user() -> Option<PathBuf> {
    let folders = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(folders.cache_dir().join("wgdenoise"))
}

/// Replaces a file as a whole, so that other processes see the old or the new one; makes its
/// folder first.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let write = |out: &mut wgdenoise_files::Out<'_>| out.write_all(bytes).map_err(Problem::Write);
    wgdenoise_files::replace(path, true, write).map_err(|error| error.to_string())
}

/// A measurement and its day.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kept {
    pub(super) calibration: Calibration,
    pub(super) date: String,
}

/// The file: a JSON object with an entry for every adapter, driver and precision that was
/// measured. Whatever is wrong with it, it is as if nothing had been kept.
pub(super) struct Cache(PathBuf);

impl Cache {
    /// `calibrations.json` in the user's folder.
    pub(super) fn of_user() -> Option<Self> {
        Some(Self(folder_of_user()?.join("calibrations.json")))
    }

    /// What was kept under `key`.
    pub(super) fn find(&self, key: &str) -> Option<Kept> {
        let entries = self.entries();
        let entry = entries.get(key)?;
        let cost = |name: &str| {
            let number = |part| entry[name][part].as_f64().filter(|v| v.is_finite() && *v >= 0.0);
            Some(Cost { fixed: number("fixed")?, per_pixel: number("per_pixel")? })
        };
        Some(Kept {
            calibration: Calibration::new(
                Quality::ALL
                    .into_iter()
                    .filter_map(|quality| Some((quality, cost(quality.name())?))),
            ),
            date: entry["date"].as_str()?.to_string(),
        })
    }

    /// Keeps a measurement under `key`, in place of an older one and beside the others.
    pub(super) fn keep(&self, key: &str, kept: &Kept) -> Result<(), String> {
        let mut entries = self.entries();
        entries.insert(key.to_string(), entry(kept));
        write(&self.0, format!("{:#}\n", Value::Object(entries)).as_bytes())
    }

    fn entries(&self) -> Map<String, Value> {
        let bytes = fs::read(&self.0).unwrap_or_default();
        serde_json::from_slice(&bytes).unwrap_or_default()
    }
}

fn entry(kept: &Kept) -> Value {
    let mut entry = json!({"date": kept.date});
    for (quality, cost) in kept.calibration.costs() {
        entry[quality.name()] = json!({"fixed": cost.fixed, "per_pixel": cost.per_pixel});
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(seconds: f64) -> Kept {
        let cost = |factor| Cost { fixed: factor * 1e-3, per_pixel: factor * seconds };
        let calibration =
            Calibration::new(Quality::ALL.into_iter().zip([0.1, 1.0 / 3.0, 1.0].map(cost)));
        Kept { calibration, date: "2026-11-22".into() }
    }

    fn cache(folder: &tempfile::TempDir) -> Cache {
        Cache(folder.path().join("not/yet/there.json"))
    }

    #[test]
    fn what_is_kept_is_found_again_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder);
        assert_eq!(cache.find("a"), None);
        cache.keep("a", &kept(1e-7)).unwrap();
        cache.keep("b \"; ü", &kept(2e-7)).unwrap();
        cache.keep("a", &kept(3e-7)).unwrap();
        assert_eq!(cache.find("a"), Some(kept(3e-7)));
        assert_eq!(cache.find("b \"; ü"), Some(kept(2e-7)));
        assert_eq!(cache.find("c"), None);
    }

    #[test]
    fn a_damaged_file_is_as_good_as_none_and_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder);
        cache.keep("a", &kept(1e-7)).unwrap();
        let whole = fs::read_to_string(&cache.0).unwrap();
        let negative = whole.replace("0.0001", "-0.0001");
        assert_ne!(negative, whole);
        for text in ["", "{", "[1]", "\0\u{1}", "{\"a\": 7}", &whole[..whole.len() / 2], &negative]
        {
            fs::write(&cache.0, text).unwrap();
            assert_eq!(cache.find("a"), None, "{text}");
            cache.keep("a", &kept(1e-7)).unwrap();
            assert_eq!(cache.find("a"), Some(kept(1e-7)), "{text}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_said() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("not"), "a file").unwrap();
        let error = cache(&folder).keep("a", &kept(1e-7)).unwrap_err();
        assert!(error.contains("not"), "{error}");
    }
}
