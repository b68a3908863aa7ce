//! `wgdenoise compare`.

use std::fmt::Write;

use serde_json::json;

use super::args::{CompareArgs, limits};
use super::failure::Failure;
use super::print;
use wgdenoise_files::{LayerChoice, Picture};
use wgdenoise_metrics::Metrics;

/// Prints how close an image is to its reference.
pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let wanted = LayerChoice {
        color: args.color.clone(),
        no_aux: true,
        finished: true,
        limits: limits(args.max_pixels),
        ..LayerChoice::default()
    };
    let image = Picture::open(&args.image, &wanted)?;
    let reference = Picture::open(&args.reference, &wanted)?;
    let metrics = wgdenoise_metrics::compare(image.color(), reference.color())?;
    print(&if args.json { as_json(&metrics) } else { as_text(&metrics) })
}

fn as_text(m: &Metrics) -> String {
    let mut text = format!(
        "L1      {:.6}\nPSNR    {:.3} dB\nSSIM    {:.6}\nrelMSE  {:.6}\nSMAPE   {:.6}",
        m.l1, m.psnr, m.ssim, m.relmse, m.smape
    );
    if m.bad > 0 {
        let _ = write!(text, "\n{} pixels are NaN or infinite and counted as 0", m.bad);
    }
    text
}

fn as_json(m: &Metrics) -> String {
    json!({
        "l1": m.l1,
        "psnr": m.psnr,
        "ssim": m.ssim,
        "relmse": m.relmse,
        "smape": m.smape,
        "bad": m.bad,
    })
    .to_string()
}
