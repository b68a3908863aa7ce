//! The command line's grammar.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use wgdenoise_files::frames::{self, Frames};

use crate::groups::{
    ChoiceArgs, DeviceArgs, LAYERS, LayerArgs, LightArgs, LimitArgs, NetworkArgs, OUTPUT,
    WritingArgs,
};
use crate::request::Alpha;
use crate::values::{FormatArg, runs, side, stops};

/// Shown below the long help.
const AFTER_HELP: &str = "\
EXR files keep everything but the three channels of the denoised color. Color, albedo and normal
are found by the names that renderers give them; `wgdenoise info IN` shows which.

Several images go into a folder: wgdenoise renders/*.exr clean/
In the file names of a sequence, #### or %04d stands for the frame number:
wgdenoise beauty.####.exr clean.####.exr --frames 1-48
There, [#] and [%] are a plain # and %. --skip-existing resumes a stopped run.
A pipe: render | wgdenoise - - | view
Images may replace themselves: wgdenoise renders/*.exr --in-place
Everything is checked before the first image is denoised. An image that fails is reported and the
batch continues.

To denoise a file that is named like a command, write ./info or -- info.

Shell completions: wgdenoise completions bash|zsh|fish|elvish|powershell
Manual page: wgdenoise man

Exit codes:
  0  done
  1  an input could not be read, or an output could not be written
  2  the command line was wrong
  3  no usable adapter (GPU or CPU driver), or it lacks what the flags need
  4  the device was lost, hangs or computes wrong results
  130, 143  stopped by Ctrl-C or by SIGTERM; what was written is whole";

const USAGE: &str = "wgdenoise [OPTIONS] <IN>... <OUT>\n       wgdenoise <COMMAND>";

/// Removes Monte Carlo noise from path-traced images.
#[derive(Debug, Parser)]
#[command(
    name = "wgdenoise",
    version,
    after_long_help = AFTER_HELP,
    arg_required_else_help = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    override_usage = USAGE
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) denoise: DenoiseArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Show a file's layers, which of them are used, and the cost
    Info(InfoArgs),
    /// Write a layer as PNG or JPEG without denoising
    Preview(PreviewArgs),
    /// Measure the error of an image against its reference
    Compare(CompareArgs),
    /// List the adapters
    Devices(DevicesArgs),
    /// Measure how fast an adapter denoises
    Bench(BenchArgs),
    /// Measure each step of the network
    Profile(ProfileArgs),
    /// Measure time against error for all built-in weights
    Report(ReportArgs),
    /// Convert weights of Open Image Denoise to safetensors
    Convert(ConvertArgs),
    /// Print a completion script for a shell
    #[command(hide = true)]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, in roff
    #[command(hide = true)]
    Man {
        /// The command to describe; without one, the program
        command: Option<String>,
    },
}

/// `wgdenoise IN... OUT`.
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag")]
pub(crate) struct DenoiseArgs {
    /// IN: the noisy images (EXR, PNG or JPEG); OUT, the last: where the results go. - is standard
    /// input or output
    #[arg(value_name = "FILE", required = true, hide_short_help = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
    #[command(flatten)]
    pub(crate) layers: LayerArgs,
    #[command(flatten)]
    pub(crate) light: LightArgs,
    /// What to do with the alpha: keep or denoise [default: denoise if it is fractional anywhere]
    #[arg(long, value_enum, value_name = "HOW", hide_possible_values = true,
          hide_short_help = true, help_heading = LAYERS)]
    pub(crate) alpha: Option<Alpha>,
    /// Frames of a sequence, such as 1-48,60 [default: all]
    ///
    /// A list of frames, ranges, and ranges with a step, such as -3-3,60,70-100x5.
    #[arg(long, value_name = "RANGES", value_parser = frames::parse, allow_hyphen_values = true)]
    pub(crate) frames: Option<Frames>,
    /// Average each frame of a sequence with 1 to 4 frames on either side, along its motion vectors
    ///
    /// Without motion vectors, only what does not move is averaged. Frames outside --frames are
    /// read where they are needed, but not written.
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "1",
          hide_short_help = true,
          value_parser = clap::value_parser!(u8).range(1..=4), conflicts_with = "in_place")]
    pub(crate) temporal: Option<u8>,
    /// Layer with the motion vectors [default: found by its name]
    #[arg(long, value_name = "LAYER", requires = "temporal", hide_short_help = true,
          help_heading = LAYERS)]
    pub(crate) motion: Option<String>,
    /// Brighten PNG and JPEG output by stops, such as 1.5
    #[arg(long, value_name = "EV", value_parser = stops, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,
    #[command(flatten)]
    pub(crate) writing: WritingArgs,
    /// Replace an input with its own result; without OUT, replace every input
    ///
    /// The last FILE is OUT if it is a folder, does not exist or is one of the inputs.
    #[arg(long, hide_short_help = true, help_heading = OUTPUT)]
    pub(crate) in_place: bool,
    /// Skip images whose output exists, to resume a run that was stopped
    #[arg(long, hide_short_help = true, help_heading = OUTPUT,
          conflicts_with_all = ["force", "in_place"])]
    pub(crate) skip_existing: bool,
    /// Format of standard output: exr, png or jpg [default: that of IN]
    #[arg(long, value_name = "FORMAT", value_enum, hide_possible_values = true,
          hide_short_help = true, help_heading = OUTPUT)]
    pub(crate) format: Option<FormatArg>,
    /// Read, denoise and write one image at a time: slower, but takes a third of the memory
    #[arg(long, hide_short_help = true, help_heading = OUTPUT)]
    pub(crate) no_overlap: bool,
    /// Check part of the result against the CPU reference before writing it
    #[arg(long, hide_short_help = true, help_heading = OUTPUT)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) choice: ChoiceArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Print nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Print layers, adapter, tiles and times
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// EXR, PNG or JPEG
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) layers: LayerArgs,
    #[command(flatten)]
    pub(crate) light: LightArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct PreviewArgs {
    /// EXR, PNG or JPEG
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// PNG or JPEG: clipped to [0, 1] and sRGB-encoded
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Layer or channel to show [default: the one that results are written to]
    #[arg(long, value_name = "NAME")]
    pub(crate) layer: Option<String>,
    /// Brighten by stops, such as 1.5 [default: 0]
    #[arg(long, value_name = "EV", default_value_t = 0.0, hide_default_value = true,
          value_parser = stops, allow_negative_numbers = true)]
    pub(crate) exposure: f32,
    #[command(flatten)]
    pub(crate) writing: WritingArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(crate) struct DevicesArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// The image to judge; for an EXR file, the layer that results are written to
    #[arg(value_name = "IMAGE")]
    pub(crate) image: PathBuf,
    /// The reference image
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,
    /// Layer to compare in both [default: found by its name]
    #[arg(long, value_name = "LAYER")]
    pub(crate) color: Option<String>,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags that `bench` and `profile` share.
#[derive(Debug, Args)]
pub(crate) struct MeasureArgs {
    /// Pixels per row [default: 1024]
    #[arg(long, value_name = "N", default_value_t = 1024, hide_default_value = true,
          value_parser = side())]
    pub(crate) width: u32,
    /// Rows [default: 1024]
    #[arg(long, value_name = "N", default_value_t = 1024, hide_default_value = true,
          value_parser = side())]
    pub(crate) height: u32,
    /// Number of runs; the median is reported [default: 5]
    #[arg(long, value_name = "N", default_value_t = 5, hide_default_value = true,
          value_parser = runs())]
    pub(crate) runs: u32,
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    #[command(flatten)]
    pub(crate) measure: MeasureArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ProfileArgs {
    #[command(flatten)]
    pub(crate) measure: MeasureArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// The noisy image
    #[arg(value_name = "NOISY")]
    pub(crate) noisy: PathBuf,
    /// The converged image
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,
    /// Folder for report.md, report.json and a plot, report.svg
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Replace a report that exists
    #[arg(long, requires = "out")]
    pub(crate) force: bool,
    /// Runs of each configuration; the median is reported [default: 5]
    #[arg(long, value_name = "N", default_value_t = 5, hide_default_value = true,
          value_parser = runs())]
    pub(crate) runs: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) layers: LayerArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// The TZA file under its original name, such as rt_hdr_alb_nrm.tza
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// The safetensors file to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Replace OUT if it exists
    #[arg(long)]
    pub(crate) force: bool,
}
