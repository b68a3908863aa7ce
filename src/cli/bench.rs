//! `wgdenoise bench`.

use super::args::BenchArgs;
use super::failure::Failure;

/// Measures.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let _ = args;
    Err(Failure::Usage("not written yet".into()))
}
