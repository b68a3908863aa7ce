//! Repeated runs and their median.

use crate::error::Result;

/// The median of one or more times, sorted shortest first; for an even count, the longer of the
/// middle two.
#[must_use]
pub fn median(seconds: &[f64]) -> f64 {
    seconds[seconds.len() / 2]
}

/// Calls `run`, which returns its own time in seconds, once to warm up and then `runs` times (at
/// least once). Returns the times of the latter, shortest first.
///
/// # Errors
/// Fails if `run` does.
pub fn repeat(runs: u32, mut run: impl FnMut() -> Result<f64>) -> Result<Vec<f64>> {
    run()?;
    let mut seconds = (0..runs.max(1)).map(|_| run()).collect::<Result<Vec<_>>>()?;
    seconds.sort_by(f64::total_cmp);
    Ok(seconds)
}
