//! The command line: parses words into a request, carries it out and reports the outcome.

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

mod args;
mod bench;
mod budget;
mod cache;
mod console;
mod denoise;
mod failure;
mod gaps;
mod groups;
pub mod host;
mod inspect;
mod interrupt;
mod parse;
mod plan;
mod report;
mod request;
mod session;
mod stages;
mod temporal;
mod values;
mod weights;

use crate::console::{Console, Verbosity};
use crate::request::Request;

pub use crate::failure::Failure;

/// Runs the program with the words of its command line.
#[must_use]
pub fn main() -> ExitCode {
    wgdenoise::panics::silence_caught();
    let words: Vec<_> = std::env::args_os().collect();
    ExitCode::from(run_words(&words))
}

/// Runs the program with these words, its name first, and returns its exit code: 0 done, 1 an input
/// or output failed, 2 wrong usage, 3 no usable adapter, or it lacks what the flags need, 4 the
/// device failed.
///
/// Ends the process itself after help, after words that the grammar refuses, and after a failure of
/// the device. Use it in a `main`; programs that must go on use [`host::denoise`].
#[must_use]
pub fn run_words(words: &[OsString]) -> u8 {
    wgdenoise::Gpu::silence_device_select();
    match parse::parse(words).and_then(run) {
        Ok(()) => 0,
        Err(failure) => {
            Console::new(Verbosity::Quiet).error(&failure);
            if let Failure::Device(_) = failure {
                // The device may still be at work, as after a timeout.
                let _ = std::io::stdout().flush();
                interrupt::end_at_once(failure.exit_code().into());
            }
            failure.exit_code()
        }
    }
}

fn run(request: Request) -> Result<(), Failure> {
    let console = Console::new(Verbosity::Normal);
    match request {
        Request::Denoise(request) => denoise::run(&request, &Console::new(request.verbosity), None),
        Request::Info(request) => inspect::info(&request),
        Request::Preview(request) => inspect::preview(&request, &console),
        Request::Compare(request) => inspect::compare(&request, &console),
        Request::Devices { json } => inspect::devices(json),
        Request::Bench(request) => bench::bench(&request, &console),
        Request::Profile(request) => bench::profile(&request, &console),
        Request::Report(request) => report::run(&request, &console),
        Request::Convert(request) => weights::convert(&request, &console),
        Request::Print(text) => console::print_bytes(&text),
    }
}

/// Entry points of the fuzz targets; not part of the interface.
#[doc(hidden)]
pub mod fuzzing {
    use std::ffi::OsString;

    use clap::Parser as _;

    use wgdenoise_files::frames::{self, Pattern};

    use crate::args::Cli;

    /// Whether the grammar accepts the words of a command line, the program's name first.
    pub fn accepts<'a>(words: impl IntoIterator<Item = &'a str>) -> bool {
        let words = words.into_iter().map(OsString::from);
        Cli::try_parse_from(words).map_err(|error| error.to_string()).is_ok()
    }

    /// The frames that `--frames` would take.
    ///
    /// # Errors
    /// If the text is not a list of frames, or names too many.
    pub fn parse_frames(text: &str) -> Result<Vec<i64>, String> {
        frames::parse(text).map(|frames| frames.0)
    }

    /// The name of a frame's file, and the frame that this name is parsed back to; `None` if the
    /// pattern has no place for a frame number.
    ///
    /// # Errors
    /// If the pattern cannot be used.
    pub fn name_and_back(
        pattern: &str,
        frame: i64,
    ) -> Result<Option<(OsString, Option<i64>)>, String> {
        let name_and_back = |pattern: Pattern| {
            let name = pattern.name(frame);
            let back = pattern.frame(&name);
            (name, back)
        };
        Pattern::parse(pattern.as_ref()).map(|pattern| pattern.map(name_and_back))
    }
}
