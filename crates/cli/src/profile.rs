//! `wgdenoise bench --profile`.

use std::fmt::Write as _;

use super::args::BenchArgs;
use super::failure::Failure;
use wgdenoise::{CallProfile, Denoiser, measure};

/// The median time of each kernel call of a frame, its share of the sum, and what it reaches.
pub(super) fn table(denoiser: &Denoiser, args: &BenchArgs) -> Result<String, Failure> {
    let rows = measure::profile(denoiser, args.width, args.height, args.runs)?;
    let total: f64 = rows.iter().map(CallProfile::median).sum();
    let mut text = format!("{:<18}{:>10}{:>8}{:>10}{:>9}\n", "call", "ms", "%", "GFLOP/s", "GB/s");
    for row in &rows {
        let (seconds, name) = (row.median(), &row.name);
        let rate = |amount: f64| format!("{:.1}", amount / seconds / 1e9);
        let (ms, share) = (seconds * 1e3, seconds / total * 100.0);
        let (gflops, gbs) = (rate(2.0 * row.macs), rate(row.bytes));
        let _ = writeln!(text, "{name:<18}{ms:>10.3}{share:>8.1}{gflops:>10}{gbs:>9}");
    }
    let _ = write!(text, "{:<18}{:>10.3}", "sum of medians", total * 1e3);
    Ok(text)
}
