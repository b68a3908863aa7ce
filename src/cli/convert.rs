//! `wgdenoise convert`.

use std::io::Write as _;

use super::args::ConvertArgs;
use super::failure::Failure;
use super::{say, weights};
use crate::Weights;
use crate::files::{Problem, replace};
use crate::model::tza;

/// Writes a weights file of Open Image Denoise as one of this program's, after checking it.
pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    if args.output.exists() && !args.force {
        return Err(Failure::Work(format!(
            "{}: exists already; give another name, or --force to replace it",
            args.output.display()
        )));
    }
    let bytes = weights::read(&args.input)?;
    let wrong = |error| Failure::Work(format!("{}: {error}", args.input.display()));
    let converted = tza::to_safetensors(&bytes, &weights::stem(&args.input)).map_err(wrong)?;
    let checked = Weights::from_bytes(&converted).map_err(wrong)?;
    replace(&args.output, args.force, |out| out.write_all(&converted).map_err(Problem::Write))?;
    let metadata = checked.metadata();
    let (name, curve) = (&metadata.name, metadata.transfer_function.name());
    say(&format!("`{name}`: {}, transfer function {curve}", metadata.inputs));
    Ok(())
}
