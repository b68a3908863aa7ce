//! `wgdenoise report NOISY REFERENCE`: time against error of the built-in weights.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::cache;
use crate::console::{Console, print, print_json};
use crate::failure::{Failure, shown};
use crate::inspect;
use crate::request;
use crate::session;
use wgdenoise::{Denoiser, Frame, Gpu, Options, Quality, Weights};
use wgdenoise_files::{LayerChoice, Out, Picture, Problem, comparison};
use wgdenoise_metrics::Metrics;

mod labels;
mod measure;
mod plot;
mod table;

use self::measure::Row;

/// The files written to `--out`.
const MARKDOWN: &str = "report.md";
const JSON: &str = "report.json";
const PLOT: &str = "report.svg";

/// The content of a report.
struct Report {
    /// The file names.
    noisy: String,
    reference: String,
    width: u32,
    height: u32,
    /// Adapter, backend, driver and kernels.
    device: String,
    runs: u32,
    /// The noisy image's metrics.
    before: Metrics,
    rows: Vec<Row>,
}

/// Measures every configuration, prints the table, and writes it together with the plot.
pub(crate) fn run(request: &request::Report, console: &Console) -> Result<(), Failure> {
    let picture = Picture::open(&request.noisy, &request.layers)?;
    let finished = LayerChoice { no_aux: true, finished: true, ..request.layers.clone() };
    let truth = Picture::open(&request.reference, &finished)?;
    if let Some(folder) = &request.out {
        prepare(folder, request.force)?;
    }
    let differences = comparison::differences(&picture, &truth);
    let (view, truth) = (picture.first(), truth.first().color());
    let before = wgdenoise_metrics::compare(view.color(), truth)?;
    for notice in differences.into_iter().chain(inspect::bad_pixels(&before)) {
        console.notice(&notice);
    }
    let (gpu, options) = session::open(&request.device)?;
    let (width, height) = view.color().size();
    let frame = Frame::new(view.color())
        .albedo(view.albedo())
        .normal(view.normal())
        .panorama(view.is_panorama());
    let report = Report {
        noisy: name(&request.noisy),
        reference: name(&request.reference),
        width,
        height,
        device: device(&gpu, &kernels(&gpu, &options, console)?),
        runs: request.runs,
        before,
        rows: measure::rows(&gpu, &options, &frame, truth, request.runs, console),
    };
    cache::keep_pipelines(&gpu, &options);
    report.deliver(request, console)
}

/// The kernels that run with these options; prints a notice if they are not the ones asked for.
fn kernels(gpu: &Gpu, options: &Options, console: &Console) -> Result<String, Failure> {
    let weights = Weights::builtin(Quality::Fast)?;
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?;
    denoiser.take_notices().iter().for_each(|notice| console.notice(notice));
    Ok(denoiser.kernels().to_string())
}

impl Report {
    fn deliver(&self, request: &request::Report, console: &Console) -> Result<(), Failure> {
        let markdown = table::markdown(self);
        if request.json { print_json(&table::json(self)) } else { print(&markdown) }?;
        if self.rows.iter().all(|row| row.measured().is_none()) {
            return Err(Failure::Work("nothing could be measured; the report tells why".into()));
        }
        let Some(folder) = &request.out else { return Ok(()) };
        let plot = plot::svg(self).map_err(|e| Failure::Work(format!("the plot: {e}")))?;
        let markdown = format!("{markdown}\n\n![Time against error]({PLOT})");
        let json = table::json(self).to_string();
        for (name, text) in [(MARKDOWN, markdown), (JSON, json), (PLOT, plot)] {
            write(&folder.join(name), request.force, &text)?;
        }
        console.notice(&format!("wrote {MARKDOWN}, {JSON} and {PLOT} to {}", shown(folder)));
        Ok(())
    }
}

/// Creates the folder; checks before any work is done that the files can be written.
fn prepare(folder: &Path, force: bool) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Problem::Write(error).at(folder))?;
    for name in [MARKDOWN, JSON, PLOT] {
        wgdenoise_files::check_place(&folder.join(name), force)?;
    }
    Ok(())
}

fn write(path: &Path, force: bool, text: &str) -> Result<(), Failure> {
    let write = |out: &mut Out<'_>| writeln!(out, "{text}").map_err(Problem::Write);
    Ok(wgdenoise_files::replace(path, force, write)?)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn device(gpu: &Gpu, kernels: &str) -> String {
    let info = &gpu.info;
    format!(
        "{} ({:?}, {} {}), kernels {kernels}",
        info.name, info.backend, info.driver, info.driver_info
    )
}
