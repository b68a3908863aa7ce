//! The command line's grammar.

use std::path::PathBuf;

use clap::Parser;

/// Shows a render noisy and denoised, with its reference if there is one.
#[derive(Debug, Parser)]
#[command(name = "wgdenoise-view", version)]
pub(crate) struct Args {
    /// Noisy images: EXR, PNG or JPEG. Arrow keys step through several, or through the frames
    /// around one
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// The same view rendered with many samples, to measure errors against
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,
}
