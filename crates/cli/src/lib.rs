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
mod fit;
mod frames;
mod info;
mod jobs;
mod options;
pub(crate) mod pipelines;
mod prefilter;
mod profile;
mod progress;
mod report;
mod values;
mod weights;

use self::args::{Cli, Command};
use self::failure::Failure;

/// What fuzz targets reach of the inside; no part of the interface.
#[doc(hidden)]
pub mod fuzzing {
    use clap::Parser as _;

    use super::args::Cli;
    use super::frames::{self, Pattern};

    /// Whether the grammar accepts the words of a command line, the program's name first.
    pub fn accepts<'a>(words: impl IntoIterator<Item = &'a str>) -> bool {
        let words = words.into_iter().map(std::ffi::OsString::from);
        Cli::try_parse_from(words).map_err(|error| error.to_string()).is_ok()
    }

    /// The frames of `--frames`, or why the text names none.
    ///
    /// # Errors
    /// If the text is none, or names too many.
    pub fn parse_frames(text: &str) -> Result<Vec<u32>, String> {
        frames::parse(text).map(|frames| frames.0)
    }

    /// The name of a frame's file by a pattern, and the frame that this name is read back as;
    /// `None` if the name has no place for a frame number.
    ///
    /// # Errors
    /// If the pattern cannot be used.
    pub fn name_and_back(
        pattern: &str,
        frame: u32,
    ) -> Result<Option<(String, Option<u32>)>, String> {
        let name_and_back = |pattern: Pattern| {
            let name = pattern.name(frame);
            let back = pattern.frame(&name);
            (name, back)
        };
        Pattern::parse(pattern).map(|pattern| pattern.map(name_and_back))
    }
}

/// Runs the program and returns its exit code: 0 done, 1 failed input or output, 2 wrong usage,
/// 3 no usable adapter, 4 the device failed.
#[must_use]
pub fn main() -> ExitCode {
    wgdenoise::Gpu::silence_device_select();
    wgdenoise::panics::silence_caught();
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
    let _ = writeln!(std::io::stderr(), "wgdenoise: {}", harmless(text));
}

/// Writes a result to stdout; a reader that has gone away is no failure.
fn print(result: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{}", harmless(result)).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("stdout: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Nothing that a terminal would obey: the names that a file holds can be anything.
fn harmless(text: &str) -> String {
    let obeyed = |c: char| c.is_control() && c != '\n';
    let shown = |c| if obeyed(c) { char::escape_default(c).to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown_instead() {
        assert_eq!(harmless("a\u{1b}[2J\r\u{9b}1m\u{7}"), r"a\u{1b}[2J\r\u{9b}1m\u{7}");
        assert_eq!(harmless("two\nlines – naïve"), "two\nlines – naïve");
    }
}
