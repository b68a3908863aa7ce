//! The command line's grammar.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Parser, Subcommand};

use super::budget::BudgetArgs;
use super::failure::Failure;
use super::frames::{self, Frames};
use super::prefilter::PrefilterArgs;
use super::values::{KernelsArg, PrecisionArg, QualityArg, pixels, positive, seconds, side};
use wgdenoise_files::{LayerChoice, Limits};

const AFTER_HELP: &str = "\
EXR files keep everything but the three channels of the denoised colour. Colour, albedo and
normal are found by the names that renderers give them; `wgdenoise info IN` says which.

Several pictures go into a folder that is there: renders/*.exr clean/. In the frames of an
animation, # or %04d stands for the number: beauty.####.exr clean.####.exr --frames 1-48. All
is checked before the first is denoised; a picture that fails does not keep the others back.
Of a folder of weights, each picture gets those for what it has.

To denoise a file that is called like a command, write ./info or -- info.

Exit codes:
  0  done
  1  an input could not be read, or the output not be made
  2  the command line was wrong
  3  no usable adapter (GPU or CPU driver)
  4  the device was lost, hangs or computes wrong results";

/// Removes Monte Carlo noise from path-traced images.
#[derive(Debug, Parser)]
#[command(
    name = "wgdenoise",
    version,
    after_help = AFTER_HELP,
    arg_required_else_help = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    override_usage = "wgdenoise [OPTIONS] <IN>... <OUT>\n       wgdenoise <COMMAND>"
)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Option<Command>,
    #[command(flatten)]
    pub(super) denoise: DenoiseArgs,
}

/// What to do other than denoise.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Show the layers of a file, which would be used and why, and what denoising costs
    Info(InfoArgs),
    /// List the adapters
    Devices(DevicesArgs),
    /// Measure how close an image is to its reference
    Compare(CompareArgs),
    /// Measure how fast an adapter denoises
    Bench(BenchArgs),
    /// Turn a weights file of Open Image Denoise into one of this program's format
    Convert(ConvertArgs),
}

/// `wgdenoise IN... OUT`.
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag")]
pub(super) struct DenoiseArgs {
    /// IN... OUT: the noisy pictures (EXR, PNG or JPEG), and where the results go
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Which frames of IN, such as 1-48,60,70-100x5 [default: all there are]
    #[arg(long, value_name = "RANGES", value_parser = frames::parse)]
    pub(super) frames: Option<Frames>,
    #[command(flatten)]
    pub(super) layers: LayerArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    /// Factor that brings the colour to a middle grey of 0.18 [default: measured; 1 with weights
    /// for sRGB or for normals]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(super) input_scale: Option<f32>,
    #[command(flatten)]
    pub(super) budget: BudgetArgs,
    #[command(flatten)]
    pub(super) prefilter: PrefilterArgs,
    /// Check a part of the result against the CPU before it is written
    #[arg(long)]
    pub(super) verify: bool,
    /// Replace outputs that exist
    #[arg(long)]
    pub(super) force: bool,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub(super) quiet: bool,
    /// Also say adapter, kernels, tiles and times
    #[arg(short, long)]
    pub(super) verbose: bool,
}

/// Which layers to read.
#[derive(Debug, Default, Args)]
pub(super) struct LayerArgs {
    /// The layer to denoise [default: found by its name]
    #[arg(long, value_name = "LAYER")]
    color: Option<String>,
    /// The layer or the file with the albedo [default: found by its name]
    #[arg(long, value_name = "LAYER|FILE", conflicts_with = "no_aux")]
    albedo: Option<String>,
    /// The layer or the file with the normals [default: found by its name]
    #[arg(long, value_name = "LAYER|FILE", conflicts_with = "no_aux")]
    normal: Option<String>,
    /// Use neither albedo nor normal
    #[arg(long)]
    no_aux: bool,
    /// Most pixels of an image that are accepted [default: 268435456, which is 16384×16384]
    #[arg(long, value_name = "N", value_parser = pixels())]
    max_pixels: Option<u64>,
}

/// What denoises, and how.
#[derive(Debug, Args)]
pub(super) struct EngineArgs {
    /// Which of the built-in weights, or of those in a folder [default: balanced]
    #[arg(long, value_enum)]
    pub(super) quality: Option<QualityArg>,
    /// A weights file instead of the built-in ones, or a folder of Open Image Denoise's
    #[arg(long, value_name = "FILE|FOLDER")]
    pub(super) weights: Option<PathBuf>,
    /// Which adapter, as `wgdenoise devices` lists them [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(super) adapter: Option<String>,
    /// How intermediate values are stored [default: f16]
    #[arg(long, value_enum)]
    pub(super) precision: Option<PrecisionArg>,
    /// Most GPU memory to use, in MiB [default: 2048]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 24))]
    pub(super) memory: Option<u64>,
    /// Largest side of a tile in pixels [default: what memory and short dispatches allow]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) tile: Option<u32>,
    /// How long the adapter may take for one submission before it counts as hung [default: 60, on
    /// CPU drivers 600]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) timeout: Option<Duration>,
    /// Which variant of the convolutions runs, for tests and measurements
    #[arg(long, value_enum, default_value = "auto", hide_short_help = true)]
    pub(super) kernels: KernelsArg,
    /// Run the network on blocks without noise too, such as an empty background
    #[arg(long)]
    pub(super) no_skip: bool,
}

/// `wgdenoise info`.
#[derive(Debug, Args)]
pub(super) struct InfoArgs {
    /// The file: EXR, PNG or JPEG
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    #[command(flatten)]
    pub(super) layers: LayerArgs,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// `wgdenoise devices`.
#[derive(Debug, Args)]
pub(super) struct DevicesArgs {
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// `wgdenoise compare`.
#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// The image to judge; of an EXR file, the layer that results are written to
    #[arg(value_name = "IMAGE")]
    pub(super) image: PathBuf,
    /// What it should look like
    #[arg(value_name = "REFERENCE")]
    pub(super) reference: PathBuf,
    /// The layer to compare in both [default: found by its name]
    #[arg(long, value_name = "LAYER")]
    pub(super) color: Option<String>,
    /// Most pixels of an image that are accepted [default: 268435456, which is 16384×16384]
    #[arg(long, value_name = "N", value_parser = pixels())]
    pub(super) max_pixels: Option<u64>,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// `wgdenoise convert`.
#[derive(Debug, Args)]
pub(super) struct ConvertArgs {
    /// The TZA file, by the name that it came with, such as rt_hdr_alb_nrm.tza
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Where the safetensors file goes
    #[arg(value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Replace OUT if it exists
    #[arg(long)]
    pub(super) force: bool,
}

/// `wgdenoise bench`.
#[derive(Debug, Args)]
#[command(mut_group("LayerArgs", |layers| layers.requires("report")))]
pub(super) struct BenchArgs {
    /// Pixels per row
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = side())]
    pub(super) width: u32,
    /// Rows
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = side())]
    pub(super) height: u32,
    /// How often to denoise; the median is reported
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(super) runs: u32,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
    /// Print how long each layer takes instead, by the adapter's timestamps
    #[arg(long, conflicts_with_all = ["json", "report"])]
    pub(super) profile: bool,
    /// Instead, measure time against error of all built-in weights on an image of yours
    #[arg(long, num_args = 2, value_names = ["NOISY", "REFERENCE"],
          conflicts_with_all = ["width", "height", "quality", "weights", "precision"])]
    report: Option<Vec<PathBuf>>,
    /// Where the report goes as report.md, report.json and, as a plot, report.svg
    #[arg(long, value_name = "FOLDER", requires = "report")]
    pub(super) out: Option<PathBuf>,
    /// Replace a report that is there
    #[arg(long, requires = "out")]
    pub(super) force: bool,
    #[command(flatten)]
    pub(super) layers: LayerArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
}

impl BenchArgs {
    /// The noisy image and the reference of `--report`.
    pub(super) fn report(&self) -> Option<[&Path; 2]> {
        self.report.as_deref().map(|files| [files[0].as_path(), files[1].as_path()])
    }
}

impl DenoiseArgs {
    /// Every IN, and OUT.
    ///
    /// # Errors
    /// If not even two files are named.
    pub(super) fn files(&self) -> Result<(&[PathBuf], &Path), Failure> {
        match self.files.split_last() {
            Some((output, inputs)) if !inputs.is_empty() => Ok((inputs, output)),
            _ => Err(Failure::Usage("give IN and OUT, or a command; see --help".into())),
        }
    }
}

impl From<&LayerArgs> for LayerChoice {
    fn from(args: &LayerArgs) -> Self {
        Self {
            color: args.color.clone(),
            albedo: args.albedo.clone(),
            normal: args.normal.clone(),
            no_aux: args.no_aux,
            finished: false,
            limits: limits(args.max_pixels),
        }
    }
}

/// The limits of `--max-pixels`.
pub(super) fn limits(max_pixels: Option<u64>) -> Limits {
    max_pixels.map_or_else(Limits::default, |pixels| Limits { pixels })
}

#[cfg(test)]
#[path = "args_test.rs"]
mod tests;
