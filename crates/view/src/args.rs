//! The command line's grammar.

use std::path::PathBuf;

use clap::Parser;

/// Shows a render noisy and denoised, with its reference if there is one.
#[derive(Debug, Parser)]
#[command(name = "wgdenoise-view", version)]
pub(crate) struct Args {
    /// Noisy images: EXR, PNG or JPEG. Arrow keys lead through several, or through the frames next to
    /// one
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// What the image would be with many samples, to measure errors against
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,
}
