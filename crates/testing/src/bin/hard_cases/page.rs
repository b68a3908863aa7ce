//! The page: one row per case.

use std::fs;
use std::path::Path;

use wgdenoise::{Image, Precision, Quality, Weights};

use crate::Result;
use crate::plot;
use crate::tensors::{self, Images};
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::hard_cases::cases::{Case, Measure, cases, noisy};
use wgdenoise_testing::hard_cases::engines::{engine, on_cpu};
use wgdenoise_testing::hard_cases::measure::measure;

/// What the sound picture is called among the inputs.
const SOUND: &str = "the noisy picture";

const INTRODUCTION: &str = "\
# Hard cases

Written by `python benches/peers/hard_cases.py`; the prose is in `examples/hard_cases/page.rs`. The
cases are the table of `tests/hard_cases/cases.rs`, which the tests hold to the goal, or, where it is
missed, to what was reached; `tests/hard_cases/measure.rs` says how each measure is taken. In every
case all values must be finite and not negative, or the figure is ∞. Where nothing else is said, the
picture is 128×96, noise of 0.7 times the value on gradients, a wave and a disc, in colour alone, with
the `balanced` weights. Beside ours stands Intel Open Image Denoise 2.5.1 (package pyoidn) on the CPU,
HDR mode, high quality. In bold: the goal is missed.
";

const ENDING: &str = "
Images without noise come back as they were since blocks without noise keep their input: the network
itself would miss constants by some per cent at the borders.

## What is missed

- The `fast` weights take a checkerboard of single pixels for noise, whose mean they miss by 0.16; the
  `high` weights hold it, as these do, which trained on such textures.
- Exposures in 16-bit tensors: pixels times a factor round otherwise, and where a tensor's value then
  rounds to the next, that is 2^-11 of it. Tensors of 32 bits hold the goal.
- A lone pixel on black is taken for a firefly and goes. Two fireflies that touch take each other for
  a light and stay.

## What the repair does to renders

Outliers are darkened before the network. On the 16 test views of [quality.md](quality.md), with `balanced` and all
inputs, the light of the denoised pictures where the reference is brightest, one pixel in a hundred, as a share of the
reference's, and the errors, without the repair and with it (`python -m quality.highlights WEIGHTS FOLDER ...` in
`training/`):

| samples | pixels darkened | L1 | with repair | relMSE | with repair | light | with repair |
|---|---|---|---|---|---|---|---|
| 2 | 5.0e-4 | 0.0353 | 0.0354 | 0.0544 | 0.0540 | 0.7504 | 0.7495 |
| 8 | 3.3e-4 | 0.0274 | 0.0274 | 0.0328 | 0.0327 | 0.8019 | 0.7998 |
| 32 | 2.7e-4 | 0.0228 | 0.0228 | 0.0258 | 0.0245 | 0.8461 | 0.8439 |
| 128 | 2.0e-5 | 0.0207 | 0.0207 | 0.0223 | 0.0223 | 0.8675 | 0.8675 |

The converged references, where highlights are what they are, keep 0.9991 of that light on average and 0.9883 at
least: the rest of that view's is fireflies of its own. That a fifth of the light is missing before the repair too is
the network's, whose training rewards the median of skewed noise.

## How rounding grows

![Error by layer](hard-cases/growth.svg)

*The error of every layer's tensor on the GPU against the reference, whose sums have 64 bits: root of the
mean square, relative to that of the values. Plain kernels, each layer reading what the one before it
stored. Dotted: 2^-24 and 2^-11, what a store rounds by, times the root of the number of layers, which
a random walk would reach. The tests hold every layer of the `fast` weights to four times that.*
";

/// What every case starts from, and the picture that most of them spoil.
pub(crate) fn inputs() -> Images {
    let cases = cases().into_iter().map(|case| (case.name, case.color));
    cases.chain([(SOUND.into(), noisy())]).collect()
}

/// Measures everything and writes the page.
pub(crate) fn write(others: &Path, docs: &Path) -> Result<()> {
    let others = tensors::read(others)?;
    let other = |case: &str| others.get(case).ok_or_else(|| format!("no result of `{case}`"));
    let weights = Weights::builtin(Quality::Balanced).map_err(|e| e.to_string())?;
    let on_gpu = |precision| engine(gpu(), &weights, precision, None);
    let engines: [&dyn Fn(&Image) -> Image; 3] =
        [&on_gpu(Precision::F16), &on_gpu(Precision::F32), &|image| on_cpu(&weights, image)];
    let sound = engines.map(|denoise| denoise(&noisy()));
    let mut page = format!("{INTRODUCTION}\n{}\n\n{HEAD}", machine());
    for case in cases() {
        let of = |i: usize| measure(&case, &engines[i](&case.color), &sound[i]);
        let oidn = measure(&case, other(&case.name)?, other(SOUND)?);
        page += &row(&case, [of(0), of(1), of(2), oidn]);
    }
    let folder = docs.join("hard-cases");
    let to = |path: &Path, text: &str| {
        fs::write(path, text).map_err(|e| format!("{} cannot be written: {e}", path.display()))
    };
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    to(&folder.join("growth.svg"), &plot::growth(&weights)?)?;
    to(&docs.join("hard-cases.md"), &(page + ENDING))
}

const HEAD: &str = "\
| case | measure | goal | f16 | f32 | reference | OIDN |
|---|---|---|---|---|---|---|
";

fn machine() -> String {
    let info = &gpu().info;
    format!("Engine: {} ({:?}), {}.", info.name, info.backend, info.driver_info)
}

fn row(case: &Case, found: [f64; 4]) -> String {
    let figure = |value: f64| {
        // Not "too much" but "not enough", since every comparison with NaN is false.
        let text = number(value);
        if value <= case.goal { text } else { format!("**{text}**") }
    };
    let [f16, f32, reference, oidn] = found.map(figure);
    let (name, measure, goal) = (&case.name, describe(case.measure), number(case.goal));
    format!("| {name} | {measure} | {goal} | {f16} | {f32} | {reference} | {oidn} |\n")
}

fn describe(measure: Measure) -> &'static str {
    match measure {
        Measure::Changed => "pixels changed by over 10 %",
        Measure::Error => "error, times that without the fault",
        Measure::Unchanged => "largest relative change",
        Measure::Exposure(_) => "largest relative change, exposure taken back",
        Measure::Light => "largest value",
        Measure::Mean => "relative change of the mean",
        Measure::Halo(_) => "largest value elsewhere",
        Measure::Finite => "finite",
    }
}

/// Two digits, or 0 or ∞.
fn number(value: f64) -> String {
    if value.is_infinite() {
        "∞".into()
    } else if value == 0.0 || (value.fract() == 0.0 && value < 1e5) {
        format!("{value}")
    } else if (1e-3..1e3).contains(&value) {
        let digits = (1 - value.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}
