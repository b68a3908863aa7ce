//! `wgdenoise convert`.

use std::io::Write as _;

use super::args::ConvertArgs;
use super::failure::Failure;
use super::{say, weights};
use wgdenoise::Weights;
use wgdenoise::tza;
use wgdenoise_files::{Identity, Problem, replace};

/// Writes a weights file of Open Image Denoise as one of this program's, after checking it.
pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    check_output(args)?;
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

/// Refuses an output that is the input, is there, or would be read as what it is not.
fn check_output(ConvertArgs { input, output, force }: &ConvertArgs) -> Result<(), Failure> {
    let wrong = |what: &str| Err(Failure::Work(format!("{}: {what}", output.display())));
    if Identity::of(input) == Identity::of(output) {
        return wrong("is also the input; give another OUT");
    }
    if tza::is_tza(output, &[]) {
        return wrong("would be taken for a TZA file; end its name in .safetensors");
    }
    if output.exists() && !force {
        return Err(Problem::Exists.at(output).into());
    }
    Ok(())
}
