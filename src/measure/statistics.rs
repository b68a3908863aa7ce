//! Several runs, and the one in the middle.

use crate::error::Result;

/// The middle one of at least one time, shortest first; of an even number, the longer of the two.
#[must_use]
pub fn median(seconds: &[f64]) -> f64 {
    seconds[seconds.len() / 2]
}

/// Seconds that `run` says it took, once to warm up, which is left out, and then `runs` times (at
/// least once); shortest first.
///
/// # Errors
/// Those of `run`.
pub fn repeat(runs: u32, mut run: impl FnMut() -> Result<f64>) -> Result<Vec<f64>> {
    run()?;
    let mut seconds = (0..runs.max(1)).map(|_| run()).collect::<Result<Vec<_>>>()?;
    seconds.sort_by(f64::total_cmp);
    Ok(seconds)
}
