//! Runs every configuration in rounds, and finds the ones worth their time.

use std::time::Instant;

use crate::console::Console;
use wgdenoise::measure::median;
use wgdenoise::{
    Denoiser, Frame, Gpu, Image, Inputs, KernelSet, MatrixShape, Options, Precision, Quality,
    Weights,
};
use wgdenoise_metrics::Metrics;

/// A configuration and its outcome.
pub(super) struct Row {
    pub(super) quality: Quality,
    pub(super) precision: Precision,
    pub(super) inputs: Inputs,
    /// The measurement, or why it failed.
    pub(super) outcome: Result<Measured, String>,
    /// Whether no other row beats it in time or error without losing in the other.
    pub(super) front: bool,
}

impl Row {
    pub(super) fn measured(&self) -> Option<&Measured> {
        self.outcome.as_ref().ok()
    }
}

/// The measurement of a configuration.
pub(super) struct Measured {
    /// Seconds per run, shortest first.
    pub(super) seconds: Vec<f64>,
    /// The error of the result.
    pub(super) metrics: Metrics,
}

impl Measured {
    pub(super) fn median(&self) -> f64 {
        median(&self.seconds)
    }
}

/// Measures every configuration: once to warm up and to get the result, then in `runs` rounds that
/// give each one turn, so that clock drift affects all alike.
pub(super) fn rows(
    gpu: &Gpu,
    options: &Options,
    frame: &Frame<'_>,
    reference: &Image,
    runs: u32,
    console: &Console,
) -> Vec<Row> {
    let inputs = input_sets(frame.inputs());
    let denoisers = denoisers(gpu, options);
    let each = || denoisers.iter().flat_map(|d| inputs.iter().map(move |&inputs| (d, inputs)));
    console.begin(each().count() * (1 + runs as usize));
    let mut started = 0..;
    let mut tick = || started.next().into_iter().for_each(|i| console.item(i, "frames"));
    let mut rows: Vec<Row> = Vec::new();
    for (one, inputs) in each() {
        tick();
        rows.push(one.warm_up(&restricted(frame, inputs), reference));
    }
    for _ in 0..runs {
        for ((one, inputs), row) in each().zip(&mut rows) {
            tick();
            one.time(&restricted(frame, inputs), row);
        }
    }
    console.end();
    mark_front(&mut rows);
    rows
}

/// Color alone, then with each further image of the frame added.
fn input_sets(given: Inputs) -> Vec<Inputs> {
    let albedo = Inputs { albedo: given.albedo, normal: false };
    let mut sets = vec![Inputs::default(), albedo, given];
    sets.dedup();
    sets
}

fn restricted<'a>(frame: &Frame<'a>, inputs: Inputs) -> Frame<'a> {
    let (albedo, normal) = (frame.albedo, frame.normal);
    frame.albedo(albedo.filter(|_| inputs.albedo)).normal(normal.filter(|_| inputs.normal))
}

/// A denoiser, or why it cannot be made.
struct Contender {
    quality: Quality,
    precision: Precision,
    denoiser: Result<Denoiser, String>,
}

fn denoisers(gpu: &Gpu, options: &Options) -> Vec<Contender> {
    let contender = |quality, precision| {
        let matrix = MatrixShape::of(&gpu.adapter, precision);
        let kernels = match (options.kernels, matrix) {
            (KernelSet::Matrix(_), Some(shape)) => KernelSet::Matrix(shape),
            (kernels, _) => kernels,
        };
        let options = options.clone().precision(precision).kernels(kernels).matrix(matrix);
        let denoiser = Weights::builtin(quality)
            .and_then(|weights| Denoiser::new(&gpu.device, &gpu.queue, &weights, &options))
            .map_err(|error| error.to_string());
        Contender { quality, precision, denoiser }
    };
    let both = |quality| [Precision::F32, Precision::F16].map(|p| contender(quality, p));
    Quality::ALL.into_iter().flat_map(both).collect()
}

impl Contender {
    fn warm_up(&self, frame: &Frame<'_>, reference: &Image) -> Row {
        let outcome = self.run(frame).and_then(|(_, image)| {
            let metrics =
                wgdenoise_metrics::compare(&image, reference).map_err(|e| e.to_string())?;
            Ok(Measured { seconds: Vec::new(), metrics })
        });
        let Self { quality, precision, .. } = *self;
        Row { quality, precision, inputs: frame.inputs(), outcome, front: false }
    }

    /// Adds a run's time, unless an earlier run has failed.
    fn time(&self, frame: &Frame<'_>, row: &mut Row) {
        let Ok(measured) = &mut row.outcome else { return };
        match self.run(frame) {
            Ok((seconds, _)) => {
                let at = measured.seconds.partition_point(|s| *s < seconds);
                measured.seconds.insert(at, seconds);
            }
            Err(error) => row.outcome = Err(error),
        }
    }

    fn run(&self, frame: &Frame<'_>) -> Result<(f64, Image), String> {
        let denoiser = self.denoiser.as_ref().map_err(Clone::clone)?;
        let begin = Instant::now();
        let image = denoiser.denoise(frame).map_err(|error| error.to_string())?;
        Ok((begin.elapsed().as_secs_f64(), image))
    }
}

/// Marks the Pareto front: rows that no other row beats in time or error without losing in the
/// other.
fn mark_front(rows: &mut [Row]) {
    let points: Vec<_> = rows.iter().map(point).collect();
    for (row, own) in rows.iter_mut().zip(&points) {
        let Some(own) = own else { continue };
        row.front = !points.iter().flatten().any(|other| beats(*other, *own));
    }
}

/// Time and error of a measured row.
fn point(row: &Row) -> Option<(f64, f64)> {
    row.measured().map(|measured| (measured.median(), measured.metrics.l1))
}

fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    a.0 <= b.0 && a.1 <= b.1 && a != b
}

#[cfg(test)]
impl Row {
    /// A row with one run of these seconds and L1, or a failure.
    pub(super) fn made_up(outcome: Result<(f64, f64), &str>) -> Self {
        let measured = |(seconds, l1)| Measured {
            seconds: vec![seconds],
            metrics: Metrics {
                l1,
                psnr: 0.0,
                ssim: 0.0,
                relmse: 0.0,
                smape: 0.0,
                bad: 0,
                bad_reference: 0,
            },
        };
        Self {
            quality: Quality::Fast,
            precision: Precision::F32,
            inputs: Inputs::ALL,
            outcome: outcome.map(measured).map_err(String::from),
            front: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_measured_with_what_it_has() {
        let names = |albedo, normal| {
            let sets = input_sets(Inputs { albedo, normal });
            sets.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(names(false, false), ["color"]);
        assert_eq!(names(true, false), ["color", "color, albedo"]);
        assert_eq!(names(false, true), ["color", "color, normal"]);
        assert_eq!(names(true, true), ["color", "color, albedo", "color, albedo, normal"]);
    }

    #[test]
    fn a_row_that_another_beats_is_not_on_the_front() {
        let mut rows = [
            Row::made_up(Ok((2.0, 0.5))),
            Row::made_up(Ok((1.0, 0.9))),
            Row::made_up(Err("failed")),
            Row::made_up(Ok((3.0, 0.5))),
            Row::made_up(Ok((1.0, 0.95))),
            Row::made_up(Ok((2.5, 0.7))),
            Row::made_up(Ok((9.0, 0.4))),
            Row::made_up(Ok((9.0, 0.4))),
        ];
        mark_front(&mut rows);
        let front = rows.map(|row| row.front);
        assert_eq!(front, [true, true, false, false, false, false, true, true]);
    }
}
