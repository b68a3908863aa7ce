//! The command line's grammar.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use wgdenoise::Schedule;

use crate::renderer::scenes::SceneName;

const AFTER_HELP: &str = "\
In the window: drag to turn the camera, wheel to come closer, D denoises or not, S shows noisy and
denoised side by side, Esc quits.";

/// Draws a built-in scene and denoises it: in a window, or with --out into files.
#[derive(Debug, Parser)]
#[command(name = "path_tracer", after_help = AFTER_HELP)]
pub(crate) struct Args {
    /// What to draw
    #[arg(long, value_enum, default_value = "still-life")]
    pub(crate) scene: SceneName,
    /// Pixels per row and rows
    #[arg(long, value_name = "W×H", value_parser = size, default_value = "1024x768")]
    pub(crate) size: [u32; 2],
    /// Samples per pixel: of the picture with --out, else of each frame, which has 4 at most
    #[arg(long, value_name = "N", value_parser = count(), default_value = "4")]
    pub(crate) spp: u32,
    /// Another seed is other noise
    #[arg(long, value_name = "N", default_value = "0")]
    pub(crate) seed: u32,
    /// Which of the denoiser's built-in weights
    #[arg(long, value_enum, default_value = "fast")]
    pub(crate) quality: Quality,
    /// In the window, denoise in every how many frames
    #[arg(long, value_name = "N", value_parser = count(), default_value = "1")]
    pub(crate) every: u32,
    /// In the window, the samples per pixel at which noisy and denoised have equal shares
    #[arg(long, value_name = "N", default_value_t = Schedule::default().half_life)]
    pub(crate) half_life: f32,
    /// Which adapter: a part of its name [default: the fastest kind]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// Write colour, albedo and normal to this EXR file, rather than open a window
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Where the denoised colour goes [default: OUT with .denoised.exr]
    #[arg(long, value_name = "FILE", requires = "out")]
    pub(crate) denoised: Option<PathBuf>,
    /// Also write a picture with many samples
    #[arg(long, value_name = "FILE", requires = "out")]
    pub(crate) reference: Option<PathBuf>,
    /// Its samples per pixel
    #[arg(long, value_name = "N", value_parser = count(), default_value = "1024")]
    pub(crate) reference_spp: u32,
}

impl Args {
    /// When the window denoises, and how much.
    pub(crate) fn schedule(&self) -> Schedule {
        Schedule { every: self.every, half_life: self.half_life }
    }
}

/// The denoiser's quality on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Quality {
    /// The least work
    Fast,
    /// Between the two
    Balanced,
    /// The best picture
    High,
}

impl From<Quality> for wgdenoise::Quality {
    fn from(quality: Quality) -> Self {
        match quality {
            Quality::Fast => Self::Fast,
            Quality::Balanced => Self::Balanced,
            Quality::High => Self::High,
        }
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', '×']).and_then(|(width, height)| {
        let side = |text: &str| text.parse().ok().filter(|&side| side > 0);
        Some([side(width)?, side(height)?])
    });
    sides.ok_or_else(|| "expected two numbers above 0, such as 1024x768".into())
}

fn count() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=65536)
}
