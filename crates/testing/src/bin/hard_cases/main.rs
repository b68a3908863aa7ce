//! Writes `docs/hard-cases.md`: the hard cases with the results of the engine, the reference, and
//! another denoiser, whose results come from a file.
//!
//! `benches/peers/hard_cases.py` runs all the steps: inputs, Open Image Denoise, page.

mod page;
mod plot;
mod tensors;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Errors are sentences.
type Result<T> = std::result::Result<T, String>;

/// Measures the hard cases.
#[derive(Debug, Parser)]
enum Command {
    /// Write the inputs to a safetensors file, `[height, width, 3]` each
    Inputs {
        /// The file
        file: PathBuf,
    },
    /// Measure, and write hard-cases.md and hard-cases/growth.svg
    Page {
        /// Another denoiser's results, named and shaped like the inputs
        others: PathBuf,
        /// The folder of the page
        docs: PathBuf,
    },
}

fn main() -> ExitCode {
    let result = match Command::parse() {
        Command::Inputs { file } => tensors::write(&file, &page::inputs()),
        Command::Page { others, docs } => page::write(&others, &docs),
    };
    if let Err(error) = result {
        eprintln!("hard_cases: error: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
