//! The command line; the library does everything.

use std::process::ExitCode;

fn main() -> ExitCode {
    wgdenoise_cli::main()
}
