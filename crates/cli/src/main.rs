//! The command line; see the library for everything it does.

use std::process::ExitCode;

fn main() -> ExitCode {
    wgdenoise_cli::main()
}
