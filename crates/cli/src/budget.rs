//! `--budget`: the best built-in weights that an adapter can run in a given time.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::cache;
use crate::console::Console;
use crate::failure::Failure;
use wgdenoise::{Calibration, Cost, Denoiser, Frame, Gpu, Options, Quality, Weights};

/// Returns a measurement of the adapter, from the user's cache or made now. A cache that cannot be
/// read or written costs time but is not a failure.
pub(crate) fn calibration(
    gpu: &Gpu,
    options: &Options,
    recalibrate: bool,
    console: &Console,
) -> Result<Measured, Failure> {
    let (file, key) = (CalibrationFile::of_user(), key(gpu, options));
    let known = file.as_ref().filter(|_| !recalibrate).and_then(|file| file.find(&key));
    if let Some(measured) = known {
        return Ok(measured);
    }
    let name = &gpu.info.name;
    console.notice(&format!("measuring what {name} can do; the result is kept for the next run"));
    let calibration = Calibration::measure(&gpu.device, &gpu.queue, options)?;
    let measured = Measured { calibration, date: today() };
    let kept = match file {
        Some(file) => file.keep(&key, &measured),
        None => Err("the user has no home folder".into()),
    };
    if let Err(error) = kept {
        console.notice(&format!("the measurement is not kept: {error}"));
    }
    Ok(measured)
}

const ALL_MEASURED: &str = "every tier was measured";

/// Chooses the best denoiser predicted to take at most `limit` for this frame, tiles included, or
/// the fastest if none is fast enough. Also returns a line that says so.
pub(crate) fn choose(
    Measured { calibration, date }: &Measured,
    limit: Duration,
    gpu: &Gpu,
    options: &Options,
    frame: &Frame<'_>,
) -> Result<(Denoiser, String), Failure> {
    let (width, height) = frame.color.size();
    let mut quality = calibration.choose(limit, width, height).expect(ALL_MEASURED).0;
    loop {
        let weights = Weights::builtin(quality)?;
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?;
        let cost = calibration.cost(quality).expect(ALL_MEASURED);
        let predicted = computed_pixels(&denoiser, frame).map(|pixels| cost.predict(pixels));
        match quality.cheaper() {
            // Too slow, or too large for the memory budget.
            Some(cheaper) if predicted.as_ref().map_or(true, |time| *time > limit) => {
                quality = cheaper;
            }
            _ => {
                let chosen = explain(quality.name(), predicted?, limit);
                let line = format!("{chosen} on {} (calibrated {date})", gpu.info.name);
                return Ok((denoiser, line));
            }
        }
    }
}

/// The pixels of all tiles, including overlap and a panorama's repeated columns.
fn computed_pixels(denoiser: &Denoiser, frame: &Frame<'_>) -> wgdenoise::Result<u64> {
    let (plan, _) = denoiser.frame_plan(frame)?;
    Ok(plan.tiles.len() as u64 * u64::from(plan.tile[0]) * u64::from(plan.tile[1]))
}

fn explain(name: &str, predicted: Duration, limit: Duration) -> String {
    let (time, allowed) = (milliseconds(predicted), milliseconds(limit));
    if predicted <= limit {
        return format!("{name}: predicted {time} of {allowed}");
    }
    format!("{name}: predicted {time}; no weights meet {allowed}, so the fastest is used")
}

/// Formats two or three significant digits.
fn milliseconds(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    if ms < 10.0 { format!("{ms:.2} ms") } else { format!("{ms:.0} ms") }
}

/// Everything that a measurement depends on.
fn key(gpu: &Gpu, options: &Options) -> String {
    let info = &gpu.info;
    format!(
        "{}; {:?}; {}; {}; {:?}; {:?} {:?}; wgdenoise {}",
        info.name,
        info.backend,
        info.driver,
        info.driver_info,
        options.precision,
        options.kernels.resolve(&gpu.device),
        options.matrix,
        env!("CARGO_PKG_VERSION")
    )
}

/// Today's date in UTC, such as `2026-11-22`.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    now.chars().take_while(|&c| c != 'T').collect()
}

/// A calibration and the day it was made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    calibration: Calibration,
    date: String,
}

/// A JSON object with an [`Entry`] for every adapter, driver and precision that was measured. A
/// damaged file counts as empty.
struct CalibrationFile(PathBuf);

/// A measurement in the file.
#[derive(Deserialize, Serialize)]
struct Entry {
    date: String,
    fast: CostEntry,
    balanced: CostEntry,
    high: CostEntry,
}

/// The costs, in seconds.
#[derive(Deserialize, Serialize)]
struct CostEntry {
    fixed: f64,
    per_pixel: f64,
}

impl CalibrationFile {
    /// `calibrations.json` in the user's cache folder.
    fn of_user() -> Option<Self> {
        Some(Self(cache::folder_of_user()?.join("calibrations.json")))
    }

    fn find(&self, key: &str) -> Option<Measured> {
        let entry = Entry::deserialize(self.entries().get(key)?).ok()?;
        entry.is_plausible().then(|| entry.into())
    }

    /// Stores a measurement under `key`, replacing an older one and keeping the others.
    fn keep(&self, key: &str, measured: &Measured) -> Result<(), String> {
        let mut entries = self.entries();
        let entry = serde_json::to_value(Entry::from(measured)).map_err(|e| e.to_string())?;
        entries.insert(key.to_string(), entry);
        cache::write(&self.0, format!("{:#}\n", Value::Object(entries)).as_bytes())
    }

    fn entries(&self) -> Map<String, Value> {
        let bytes = fs::read(&self.0).unwrap_or_default();
        serde_json::from_slice(&bytes).unwrap_or_default()
    }
}

impl Entry {
    fn costs(&self) -> [(Quality, &CostEntry); 3] {
        use Quality::{Balanced, Fast, High};
        [(Fast, &self.fast), (Balanced, &self.balanced), (High, &self.high)]
    }

    fn is_plausible(&self) -> bool {
        let seconds = self.costs().into_iter().flat_map(|(_, cost)| [cost.fixed, cost.per_pixel]);
        seconds.into_iter().all(|value| value.is_finite() && value >= 0.0)
    }
}

impl From<Entry> for Measured {
    fn from(entry: Entry) -> Self {
        let cost = |c: &CostEntry| Cost { fixed: c.fixed, per_pixel: c.per_pixel };
        let costs = entry.costs().map(|(quality, entry)| (quality, cost(entry)));
        Self { calibration: Calibration::new(costs), date: entry.date }
    }
}

impl From<&Measured> for Entry {
    fn from(Measured { calibration, date }: &Measured) -> Self {
        let cost = |quality| {
            let Cost { fixed, per_pixel } = calibration.cost(quality).expect(ALL_MEASURED);
            CostEntry { fixed, per_pixel }
        };
        let [fast, balanced, high] = [Quality::Fast, Quality::Balanced, Quality::High].map(cost);
        Self { date: date.clone(), fast, balanced, high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_whether_the_budget_is_met() {
        let ms = |ms: f64| Duration::from_secs_f64(ms / 1e3);
        assert_eq!(explain("high", ms(40.0), ms(40.0)), "high: predicted 40 ms of 40 ms");
        assert_eq!(explain("high", ms(0.5), ms(1e15)).matches("0.50 ms of").count(), 1);
        assert_eq!(
            explain("fast", ms(9.5), ms(1.0)),
            "fast: predicted 9.50 ms; no weights meet 1.00 ms, so the fastest is used"
        );
    }

    #[test]
    fn a_day_has_ten_letters() {
        let today = today();
        assert!(today.len() == 10 && today.starts_with("20"), "{today}");
    }

    fn measured(seconds: f64) -> Measured {
        let cost = |factor| Cost { fixed: factor * 1e-3, per_pixel: factor * seconds };
        let calibration =
            Calibration::new(Quality::ALL.into_iter().zip([0.1, 1.0 / 3.0, 1.0].map(cost)));
        Measured { calibration, date: "2026-11-22".into() }
    }

    fn file(folder: &tempfile::TempDir) -> CalibrationFile {
        CalibrationFile(folder.path().join("not/yet/there.json"))
    }

    #[test]
    fn what_is_kept_is_found_again_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let file = file(&folder);
        assert_eq!(file.find("a"), None);
        file.keep("a", &measured(1e-7)).unwrap();
        file.keep("b \"; ü", &measured(2e-7)).unwrap();
        file.keep("a", &measured(3e-7)).unwrap();
        assert_eq!(file.find("a"), Some(measured(3e-7)));
        assert_eq!(file.find("b \"; ü"), Some(measured(2e-7)));
        assert_eq!(file.find("c"), None);
    }

    #[test]
    fn a_damaged_file_is_as_good_as_none_and_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = file(&folder);
        file.keep("a", &measured(1e-7)).unwrap();
        let whole = fs::read_to_string(&file.0).unwrap();
        let negative = whole.replace("0.0001", "-0.0001");
        let (half, no_tiers) = (&whole[..whole.len() / 2], r#"{"a": {"date": "2026-11-22"}}"#);
        assert_ne!(negative, whole);
        for text in ["", "{", "[1]", "\0\u{1}", "{\"a\": 7}", half, &negative, no_tiers] {
            fs::write(&file.0, text).unwrap();
            assert_eq!(file.find("a"), None, "{text}");
            file.keep("a", &measured(1e-7)).unwrap();
            assert_eq!(file.find("a"), Some(measured(1e-7)), "{text}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_created_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("not"), "a file").unwrap();
        let error = file(&folder).keep("a", &measured(1e-7)).unwrap_err();
        assert!(error.contains("not"), "{error}");
    }
}
