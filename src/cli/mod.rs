//! The command line.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

mod args;
mod bench;
mod budget;
mod cache;
mod compare;
mod convert;
mod denoise;
mod devices;
mod engine;
mod failure;
mod info;
pub(crate) mod pipelines;
mod prefilter;
mod profile;
mod progress;
mod report;
mod values;
mod weights;

use self::args::{Cli, Command};
use self::failure::Failure;

/// Runs the program and returns its exit code: 0 done, 1 failed input or output, 2 wrong usage,
/// 3 no usable adapter.
#[must_use]
pub fn main() -> ExitCode {
    crate::unsafe_calls::silence_loader();
    match run(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say(&format!("error: {failure}"));
            failure.exit_code()
        }
    }
}

fn run(cli: Cli) -> Result<(), Failure> {
    match cli.command {
        None => denoise::run(&cli.denoise),
        Some(Command::Info(args)) => info::run(&args),
        Some(Command::Devices(args)) => devices::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Convert(args)) => convert::run(&args),
    }
}

/// Tells the user something on stderr; that nobody can read it is no reason to lose the work.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "wgdenoise: {text}");
}

/// Writes a result to stdout; a reader that has gone away is no failure.
fn print(result: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{result}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("stdout: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
