//! `wgdenoise bench --report NOISY REFERENCE`: time against error of the built-in weights.

use std::fs;
use std::io::Write;
use std::path::Path;

use super::args::BenchArgs;
use super::failure::Failure;
use super::{pipelines, print, say};
use wgdenoise::{Denoiser, Frame, Gpu, Options, Quality, Weights};
use wgdenoise_files::{LayerChoice, Picture, Problem};
use wgdenoise_metrics::Metrics;

mod front;
mod labels;
mod marker;
mod measure;
mod plot;
mod table;

use self::measure::Row;

/// The files of `--out`.
const MARKDOWN: &str = "report.md";
const JSON: &str = "report.json";
const PLOT: &str = "report.svg";

/// All that a report says.
struct Report {
    /// The files' names.
    noisy: String,
    reference: String,
    width: u32,
    height: u32,
    /// Adapter, backend, driver and kernels.
    device: String,
    runs: u32,
    /// Of the noisy image.
    before: Metrics,
    rows: Vec<Row>,
}

/// Measures every configuration, prints the table, and writes it with the plot.
pub(super) fn run(args: &BenchArgs, noisy: &Path, reference: &Path) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        prepare(folder, args.force)?;
    }
    let picture = Picture::open(noisy, &LayerChoice::from(&args.layers))?;
    let finished = LayerChoice { no_aux: true, finished: true, ..LayerChoice::from(&args.layers) };
    let truth = Picture::open(reference, &finished)?;
    let before = wgdenoise_metrics::compare(picture.color(), truth.color())?;
    let gpu = args.engine.open_gpu()?;
    let options = args.engine.options(&gpu)?;
    let (width, height) = picture.color().size();
    let frame = Frame::new(picture.color()).albedo(picture.albedo()).normal(picture.normal());
    let report = Report {
        noisy: name(noisy),
        reference: name(reference),
        width,
        height,
        device: device(&gpu, &kernels(&gpu, &options)?),
        runs: args.runs,
        before,
        rows: measure::rows(&gpu, &options, &frame, truth.color(), args.runs),
    };
    pipelines::keep(&gpu, &options);
    report.deliver(args)
}

/// The kernels that run with these options; says why if they are not those asked for.
fn kernels(gpu: &Gpu, options: &Options) -> Result<String, Failure> {
    let weights = Weights::builtin(Quality::Fast)?;
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, options)?;
    denoiser.take_notices().iter().for_each(|notice| say(notice));
    Ok(denoiser.kernels().to_string())
}

impl Report {
    fn deliver(&self, args: &BenchArgs) -> Result<(), Failure> {
        print(&if args.json { table::json(self) } else { table::markdown(self) })?;
        if self.rows.iter().all(|row| row.measured().is_none()) {
            return Err(Failure::Work("nothing could be measured; the report says why".into()));
        }
        if let Some(folder) = &args.out {
            let plot = plot::svg(self).map_err(|e| Failure::Work(format!("the plot: {e}")))?;
            let markdown = format!("{}\n\n![Time against error]({PLOT})", table::markdown(self));
            for (name, text) in [(MARKDOWN, markdown), (JSON, table::json(self)), (PLOT, plot)] {
                write(&folder.join(name), args.force, &text)?;
            }
        }
        Ok(())
    }
}

/// Makes the folder and finds, before any work is done, what may not be replaced.
fn prepare(folder: &Path, force: bool) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Problem::Write(error).at(folder))?;
    for path in [MARKDOWN, JSON, PLOT].map(|name| folder.join(name)) {
        if !force && fs::symlink_metadata(&path).is_ok() {
            return Err(Problem::Exists.at(&path).into());
        }
    }
    Ok(())
}

fn write(path: &Path, force: bool, text: &str) -> Result<(), Failure> {
    let write =
        |out: &mut wgdenoise_files::Out<'_>| writeln!(out, "{text}").map_err(Problem::Write);
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
