//! `wgdenoise IN OUT --budget MS`.

use std::time::{Duration, SystemTime};

use clap::Args;

use super::cache::{Cache, Kept};
use super::failure::Failure;
use super::values::positive;
use wgdenoise::{Calibration, Denoiser, Frame, Gpu, Options, Weights};

/// How much time there is.
#[derive(Debug, Args)]
pub(super) struct BudgetArgs {
    /// Take the best built-in weights that are predicted to denoise in so many milliseconds
    #[arg(long, value_name = "MS", value_parser = positive,
          conflicts_with_all = ["quality", "weights"])]
    budget: Option<f32>,
    /// Measure for --budget anew what the adapter can do
    #[arg(long, requires = "budget")]
    pub(super) recalibrate: bool,
}

impl BudgetArgs {
    /// The time that `--budget` allows.
    pub(super) fn limit(&self) -> Option<Duration> {
        self.budget.map(duration)
    }
}

fn duration(milliseconds: f32) -> Duration {
    Duration::try_from_secs_f64(f64::from(milliseconds) / 1e3).unwrap_or(Duration::MAX)
}

/// What is known of the adapter, from the user's cache or measured now. A cache that cannot be
/// read or written costs time and is no failure.
pub(super) fn calibration(
    gpu: &Gpu,
    options: &Options,
    anew: bool,
    say: impl Fn(String),
) -> Result<Kept, Failure> {
    let (cache, key) = (Cache::of_user(), key(gpu, options));
    let known = cache.as_ref().filter(|_| !anew).and_then(|cache| cache.find(&key));
    if let Some(kept) = known {
        return Ok(kept);
    }
    say(format!("measures what {} can do; this is kept for the next time", gpu.info.name));
    let calibration = Calibration::measure(&gpu.device, &gpu.queue, options)?;
    let kept = Kept { calibration, date: today() };
    match cache.map(|cache| cache.keep(&key, &kept)) {
        Some(Ok(())) => {}
        Some(Err(error)) => say(format!("the measurement is not kept: {error}")),
        None => say("the measurement is not kept: the user has no home folder".into()),
    }
    Ok(kept)
}

const MEASURED: &str = "all tiers were measured";

/// The best denoiser that is predicted to take at most `limit` for this frame, tiles included,
/// and a line that says so.
pub(super) fn choose(
    kept: &Kept,
    limit: Duration,
    gpu: &Gpu,
    options: &Options,
    frame: &Frame<'_>,
) -> Result<(Denoiser, String), Failure> {
    let (width, height) = frame.color.size();
    let mut quality = kept.calibration.choose(limit, width, height).expect(MEASURED).0;
    loop {
        let weights = Weights::builtin(quality)?;
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?;
        let cost = kept.calibration.cost(quality).expect(MEASURED);
        let predicted = worked_pixels(&denoiser, frame).map(|pixels| cost.predict(pixels));
        match quality.cheaper() {
            // Too slow, or too large for the memory budget.
            Some(cheaper) if predicted.as_ref().map_or(true, |time| *time > limit) => {
                quality = cheaper;
            }
            _ => {
                let predicted = predicted?;
                let chosen = explain(quality.name(), predicted, limit);
                let line = format!("{chosen} on {} (calibrated {})", gpu.info.name, kept.date);
                return Ok((denoiser, line));
            }
        }
    }
}

/// All the pixels of all tiles.
fn worked_pixels(denoiser: &Denoiser, frame: &Frame<'_>) -> wgdenoise::Result<u64> {
    let (width, height) = frame.color.size();
    let inputs = frame.inputs().intersection(denoiser.weights().metadata().inputs);
    let plan = denoiser.tile_plan(width, height, inputs)?;
    Ok(plan.tiles.len() as u64 * u64::from(plan.tile[0]) * u64::from(plan.tile[1]))
}

fn explain(name: &str, predicted: Duration, limit: Duration) -> String {
    let (time, allowed) = (milliseconds(predicted), milliseconds(limit));
    if predicted <= limit {
        return format!("{name}: predicted {time} of {allowed}");
    }
    format!("{name}: predicted {time}, which is over the {allowed} allowed, but is the fastest,")
}

/// With two or three digits that say something.
fn milliseconds(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    if ms < 10.0 { format!("{ms:.2} ms") } else { format!("{ms:.0} ms") }
}

/// All that a measurement depends on.
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

/// The day in UTC, as `2026-11-22`.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    now.chars().take_while(|&c| c != 'T').collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_whether_the_budget_is_met() {
        let ms = duration;
        assert_eq!(explain("high", ms(40.0), ms(40.0)), "high: predicted 40 ms of 40 ms");
        assert_eq!(explain("high", ms(0.5), ms(1e38)).matches("0.50 ms of").count(), 1);
        assert!(explain("fast", ms(9.5), ms(1.0)).contains("9.50 ms, which is over the 1.00 ms"));
    }

    #[test]
    fn a_day_has_ten_letters() {
        let today = today();
        assert!(today.len() == 10 && today.starts_with("20"), "{today}");
    }
}
