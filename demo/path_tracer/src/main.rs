//! The path tracer's command: draws into a window, or into files with `--out`.

mod args;
mod frames;
mod headless;
mod window;

use std::process::ExitCode;

use clap::Parser as _;

use self::args::Args;

fn main() -> ExitCode {
    let args = Args::parse();
    let result = match &args.out {
        Some(out) => headless::run(&args, out),
        None => window::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("path_tracer: error: {error}");
            ExitCode::FAILURE
        }
    }
}
