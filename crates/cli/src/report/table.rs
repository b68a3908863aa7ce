//! Formats the report as Markdown and as JSON.

use serde_json::{Value, json};

use super::Report;
use super::measure::{Measured, Row};
use wgdenoise::{Inputs, Precision};

const HEAD: &str = "\
| quality | precision | inputs | ms | least to most | L1 | of the noisy | SSIM | front |
| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | :---: |";

const FOOT: &str = "\
L1 and SSIM as `wgdenoise compare` measures them. On the front: no other row is both faster and
closer to the reference by L1.";

/// A paragraph on what was measured, and a table.
pub(super) fn markdown(report: &Report) -> String {
    let Report { noisy, reference, width, height, device, runs, before, .. } = report;
    let of = if *runs == 1 { "One run".into() } else { format!("Medians of {runs} runs") };
    let head = format!(
        "{noisy} against {reference}, {width}×{height} pixels; the noisy image: L1 {:.4}, SSIM \
         {:.3}.\n{of} of whole frames, in rounds, on {device}.",
        before.l1, before.ssim
    );
    let rows: Vec<_> = report.rows.iter().map(|row| line(row, before.l1)).collect();
    format!("{head}\n\n{HEAD}\n{}\n\n{FOOT}", rows.join("\n"))
}

fn line(row: &Row, noisy_l1: f64) -> String {
    let name = format!("{} | {}", row.quality.name(), precision(row.precision));
    let cells = match &row.outcome {
        Ok(measured) => cells(measured, noisy_l1),
        // A bar would end the cell.
        Err(error) => format!("failed: {} | | | | ", error.replace('|', "/")),
    };
    let front = if row.front { "yes" } else { "" };
    format!("| {name} | {} | {cells} | {front} |", row.inputs)
}

fn cells(measured: &Measured, noisy_l1: f64) -> String {
    let seconds = &measured.seconds;
    format!(
        "{} | {} to {} | {:.4} | {} | {:.3}",
        milliseconds(measured.median()),
        milliseconds(seconds[0]),
        milliseconds(seconds[seconds.len() - 1]),
        measured.metrics.l1,
        relative(measured, noisy_l1).map_or("–".into(), |r| format!("{:.1} %", 100.0 * r)),
        measured.metrics.ssim
    )
}

/// The error relative to the noisy image's; `None` if that is 0.
pub(super) fn relative(measured: &Measured, noisy_l1: f64) -> Option<f64> {
    (noisy_l1 > 0.0).then_some(measured.metrics.l1 / noisy_l1)
}

/// The precision's name on the command line.
pub(super) fn precision(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F16 => "f16",
    }
}

/// Formats milliseconds with at least three significant digits.
fn milliseconds(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    match ms {
        ..10.0 => format!("{ms:.2}"),
        10.0..100.0 => format!("{ms:.1}"),
        _ => format!("{ms:.0}"),
    }
}

/// All results, unrounded.
pub(super) fn json(report: &Report) -> Value {
    let rows: Vec<Value> = report.rows.iter().map(|row| entry(row, report.before.l1)).collect();
    json!({
        "noisy": report.noisy,
        "reference": report.reference,
        "width": report.width,
        "height": report.height,
        "device": report.device,
        "runs": report.runs,
        "noisy_l1": report.before.l1,
        "noisy_ssim": report.before.ssim,
        "configurations": rows,
    })
}

fn entry(row: &Row, noisy_l1: f64) -> Value {
    let Inputs { albedo, normal } = row.inputs;
    let mut entry = json!({
        "quality": row.quality.name(),
        "precision": precision(row.precision),
        "albedo": albedo,
        "normal": normal,
        "front": row.front,
    });
    match &row.outcome {
        Err(error) => entry["error"] = json!(error),
        Ok(measured) => {
            entry["seconds"] = json!(measured.seconds);
            entry["median_seconds"] = json!(measured.median());
            entry["l1"] = json!(measured.metrics.l1);
            entry["l1_of_noisy"] = json!(relative(measured, noisy_l1));
            entry["ssim"] = json!(measured.metrics.ssim);
        }
    }
    entry
}
