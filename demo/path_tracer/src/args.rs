//! The command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use wgdenoise::Schedule;

use path_tracer::renderer::scenes::SceneName;

const AFTER_HELP: &str = "\
In the window: drag to orbit, scroll to zoom, A moves the spheres, D toggles the denoiser, T toggles
the average of frames along their motion, S shows noisy and denoised side by side, Esc quits.";

/// Draws a built-in scene and denoises it, in a window or, with --out, into files
#[derive(Debug, Parser)]
#[command(name = "path_tracer", after_help = AFTER_HELP)]
pub(crate) struct Args {
    /// Scene to draw
    #[arg(long, value_enum, default_value = "still-life")]
    pub(crate) scene: SceneName,
    /// Width and height in pixels
    #[arg(long, value_name = "W×H", value_parser = size, default_value = "1024x768")]
    pub(crate) size: [u32; 2],
    /// Samples per pixel: in total with --out, per frame (at most 4) in the window
    #[arg(long, value_name = "N", value_parser = count(), default_value = "4")]
    pub(crate) spp: u32,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value = "0")]
    pub(crate) seed: u32,
    /// Built-in weights of the denoiser
    #[arg(long, value_enum, default_value = "fast")]
    pub(crate) quality: Quality,
    /// In the window: denoise every Nth frame
    #[arg(long, value_name = "N", value_parser = count(), default_value = "1")]
    pub(crate) every: u32,
    /// In the window: samples per pixel at which noisy and denoised are blended equally
    #[arg(long, value_name = "N", default_value_t = Schedule::default().half_life)]
    pub(crate) half_life: f32,
    /// Average each of --frames with the last ones, along its motion; a window does so anyway
    #[arg(long, requires = "frames")]
    pub(crate) temporal: bool,
    /// Move the scene's spheres; the key A in the window
    #[arg(long)]
    pub(crate) animate: bool,
    /// Adapter, by a part of its name [default: the fastest kind]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// Write color, albedo and normal to this EXR file instead of opening a window
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write this many frames, 1/30 s apart: out.exr becomes out.0001.exr and so on, with motion
    /// vectors and depth
    #[arg(long, value_name = "N", value_parser = count(), requires = "out")]
    pub(crate) frames: Option<u32>,
    /// Degrees by which the camera goes around the scene from frame to frame
    #[arg(
        long,
        value_name = "DEGREES",
        requires = "frames",
        default_value = "0",
        value_parser = angle,
        allow_negative_numbers = true
    )]
    pub(crate) orbit: f32,
    /// Seconds since the spheres began to move in the first frame
    #[arg(long, value_name = "SECONDS", requires = "frames", default_value = "0", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) start: f32,
    /// EXR file for the denoised color [default: FILE of --out, with .denoised.exr]
    #[arg(long, value_name = "FILE", requires = "out")]
    pub(crate) denoised: Option<PathBuf>,
    /// Also write a reference to this EXR file
    #[arg(long, value_name = "FILE", requires = "out")]
    pub(crate) reference: Option<PathBuf>,
    /// Samples per pixel of the reference
    #[arg(long, value_name = "N", value_parser = count(), default_value = "1024")]
    pub(crate) reference_spp: u32,
}

impl Args {
    /// When the window denoises, and how much it blends.
    pub(crate) fn schedule(&self) -> Schedule {
        Schedule { every: self.every, half_life: self.half_life }
    }
}

/// The denoiser's quality on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Quality {
    /// The least work
    Fast,
    /// In between
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

fn seconds(text: &str) -> Result<f32, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e5).contains(seconds));
    seconds.ok_or_else(|| "expected a number of seconds from 0 to 100000".into())
}

fn angle(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|angle| (-180.0..=180.0).contains(angle));
    angle.ok_or_else(|| "expected an angle from -180 to 180".into())
}

fn count() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=65536)
}
