//! Writes `docs/hard-cases.md`: the table of `tests/hard_cases`, with what comes out of the engine, of
//! the reference, and of another denoiser whose results stand in a file.
//!
//! `benches/peers/hard_cases.py` runs all of it: inputs, Open Image Denoise, page.

mod page;
mod plot;
mod tensors;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// What can go wrong, as a sentence.
type Result<T> = std::result::Result<T, String>;

/// Measures the hard cases.
#[derive(Debug, Parser)]
enum Command {
    /// Write the inputs into a safetensors file, `[height, width, 3]` each
    Inputs {
        /// The file
        file: PathBuf,
    },
    /// Measure, and write hard-cases.md and hard-cases/growth.svg
    Page {
        /// Another denoiser's results, named and shaped like the inputs
        others: PathBuf,
        /// The folder with the page
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
