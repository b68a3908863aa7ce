//! Flags that several commands share.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::values::{KernelsArg, PrecisionArg, QualityArg, memory, pixels, positive, time};

pub(crate) const LAYERS: &str = "Advanced layer options";
pub(crate) const WEIGHTS: &str = "Advanced weights options";
pub(crate) const DEVICE: &str = "Advanced device options";
pub(crate) const OUTPUT: &str = "Advanced output options";

/// The choice of weights, shared with `bench` and `profile`.
#[derive(Debug, Args)]
pub(crate) struct NetworkArgs {
    /// Weights: fast, balanced or high [default: balanced]
    ///
    /// Each tier takes about twice as long as the one before.
    #[arg(long, value_name = "TIER", value_enum, hide_possible_values = true)]
    pub(crate) quality: Option<QualityArg>,
    /// Weights file to use instead of the built-in ones, or a folder of Open Image Denoise's
    #[arg(long, value_name = "FILE|FOLDER", hide_short_help = true, help_heading = WEIGHTS)]
    pub(crate) weights: Option<PathBuf>,
    /// Storage of intermediate values [default: f16]
    #[arg(long, value_enum, value_name = "TYPE", hide_short_help = true, help_heading = DEVICE)]
    pub(crate) precision: Option<PrecisionArg>,
}

/// The choice of weights, for commands that read an image.
#[derive(Debug, Args)]
pub(crate) struct ChoiceArgs {
    /// Denoise albedo and normal first, with weights from the --weights folder
    #[arg(long, requires = "weights", conflicts_with = "no_aux", hide_short_help = true,
          help_heading = WEIGHTS)]
    pub(crate) prefilter: bool,
    /// Use the best built-in weights predicted to meet this time, such as 40ms
    #[arg(long, value_name = "TIME", value_parser = time, hide_short_help = true,
          help_heading = WEIGHTS, conflicts_with_all = ["quality", "weights"])]
    pub(crate) budget: Option<Duration>,
    /// Measure the adapter again for --budget
    #[arg(long, requires = "budget", hide_short_help = true, help_heading = WEIGHTS)]
    pub(crate) recalibrate: bool,
    /// Factor that brings the color to a middle gray of 0.18 [default: measured, or 1 for weights
    /// for sRGB or normals]
    #[arg(long, value_name = "X", value_parser = positive, hide_short_help = true,
          help_heading = WEIGHTS)]
    pub(crate) input_scale: Option<f32>,
}

/// Which layers to read.
#[derive(Debug, Default, Args)]
pub(crate) struct LayerArgs {
    /// Layer to denoise [default: the color of every view]
    #[arg(long, value_name = "LAYER")]
    pub(crate) color: Option<String>,
    /// Layer or file with the albedo [default: found by its name]
    #[arg(long, value_name = "LAYER|FILE", conflicts_with = "no_aux", hide_short_help = true,
          help_heading = LAYERS)]
    pub(crate) albedo: Option<OsString>,
    /// Layer or file with the normals [default: found by its name]
    #[arg(long, value_name = "LAYER|FILE", conflicts_with = "no_aux", hide_short_help = true,
          help_heading = LAYERS)]
    pub(crate) normal: Option<OsString>,
    /// Use neither albedo nor normal
    #[arg(long, hide_short_help = true, help_heading = LAYERS)]
    pub(crate) no_aux: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Which further layers to denoise.
#[derive(Debug, Default, Args)]
pub(crate) struct LightArgs {
    /// Further light layers to denoise with the color's weights: auto, or names such as RGBA_*
    ///
    /// Names are separated by commas and may have *, ? and [...]. With auto, light groups and
    /// passes that renderers add up are found by their names; `wgdenoise info` shows which.
    #[arg(long, value_name = "NAMES|auto", hide_short_help = true, help_heading = LAYERS)]
    pub(crate) layers: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct LimitArgs {
    /// Most pixels accepted per image [default: 268435456, which is 16384×16384]
    #[arg(long, value_name = "N", value_parser = pixels(), hide_short_help = true,
          help_heading = LAYERS)]
    pub(crate) max_pixels: Option<u64>,
}

#[derive(Debug, Args)]
pub(crate) struct WritingArgs {
    /// Replace outputs that exist
    #[arg(long)]
    pub(crate) force: bool,
    /// Create missing output folders
    #[arg(long, hide_short_help = true, help_heading = OUTPUT)]
    pub(crate) parents: bool,
}

/// Where and how the network runs.
#[derive(Debug, Args)]
pub(crate) struct DeviceArgs {
    /// Adapter, as listed by `wgdenoise devices` [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", hide_short_help = true, help_heading = DEVICE)]
    pub(crate) adapter: Option<String>,
    /// Most GPU memory to use, such as 512MiB [default: 2GiB]
    #[arg(long, value_name = "SIZE", value_parser = memory, hide_short_help = true,
          help_heading = DEVICE)]
    pub(crate) memory: Option<u64>,
    /// Longest side of a tile in pixels [default: what memory and short dispatches allow]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..),
          hide_short_help = true, help_heading = DEVICE)]
    pub(crate) tile: Option<u32>,
    /// Longest wait for one submission before the adapter counts as hung, such as 90s
    /// [default: 60s, on CPU drivers 10min]
    #[arg(long, value_name = "TIME", value_parser = time, hide_short_help = true,
          help_heading = DEVICE)]
    pub(crate) timeout: Option<Duration>,
    /// Variant of the convolutions, for tests and measurements [default: auto]
    #[arg(long, value_enum, value_name = "SET", default_value = "auto",
          hide_default_value = true, hide_short_help = true, help_heading = DEVICE)]
    pub(crate) kernels: KernelsArg,
    /// Run the network on constant areas too, such as an empty background
    #[arg(long, hide_short_help = true, help_heading = DEVICE)]
    pub(crate) no_skip: bool,
}
