//! The viewer; see the library for everything it does.

use std::process::ExitCode;

fn main() -> ExitCode {
    wgdenoise_view::main()
}
