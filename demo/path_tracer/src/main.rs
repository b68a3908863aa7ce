//! A small path tracer with wgdenoise in it: how a renderer embeds a denoising pass.
//!
//! - `renderer/` draws a scene onto textures and knows nothing of the denoiser;
//! - `denoise.rs` is all that it takes to denoise them;
//! - `headless.rs` and `window/` put the two into command encoders.

mod args;
mod denoise;
mod headless;
mod renderer;
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
