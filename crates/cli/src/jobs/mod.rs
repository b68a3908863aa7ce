//! Which pictures are denoised and where each result goes, checked before any work is done.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use self::layers::Layers;
use self::source::Source;
use self::target::Target;
use super::args::DenoiseArgs;
use super::failure::Failure;
use wgdenoise_files::{Identity, LayerChoice};

mod layers;
mod sequence;
mod source;
mod target;

/// One picture.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    pub(super) layers: LayerChoice,
}

/// What the command line asks for: one picture or several, in their order.
///
/// # Errors
/// If it contradicts itself, an input is missing, or an output cannot be written, would replace
/// an input or is that of two inputs. One picture named alone may be replaced, with `--force`.
pub(super) fn plan(args: &DenoiseArgs) -> Result<Vec<Job>, Failure> {
    let (inputs, output) = args.files()?;
    let sources = inputs.iter().map(|input| Source::of(input)).collect::<Result<Vec<_>, _>>()?;
    if args.frames.is_some() && !sources.iter().any(Source::is_sequence) {
        return Err(Failure::Usage(
            "--frames needs an IN that leaves the frame number open, such as beauty.####.exr"
                .into(),
        ));
    }
    let target = Target::of(output, &sources)?;
    if let ([Source::File(input)], Target::File(output)) = (sources.as_slice(), &target) {
        wgdenoise_files::check_output(output, args.force)?;
        let (input, output) = (input.clone(), output.clone());
        return Ok(vec![Job { input, output, layers: LayerChoice::from(&args.layers) }]);
    }
    let mut jobs = Vec::new();
    for source in &sources {
        let layers = Layers::of(&args.layers, source)?;
        for (input, frame) in source.pictures(args.frames.as_ref(), &layers)? {
            let output = target.path(&input, frame);
            jobs.push(Job { input, output, layers: layers.at(frame) });
        }
    }
    check(&jobs, args.force)?;
    Ok(jobs)
}

fn check(jobs: &[Job], force: bool) -> Result<(), Failure> {
    let mut read = HashMap::new();
    for job in jobs {
        for input in job.files() {
            read.insert(Identity::of(input), input);
        }
    }
    let mut written = HashMap::new();
    for Job { input, output, .. } in jobs {
        let identity = Identity::of(output);
        let wrong = |what: String| Err(Failure::Work(format!("{}: {what}", output.display())));
        if let Some(input) = read.get(&identity) {
            return wrong(format!("is also the input {}; give another OUT", input.display()));
        }
        if let Some(other) = written.insert(identity, input) {
            let (other, input) = (other.display(), input.display());
            return wrong(format!("is the output of both {other} and {input}; denoise one by one"));
        }
        wgdenoise_files::check_output(output, force)?;
    }
    Ok(())
}

impl Job {
    /// What is read for it.
    fn files(&self) -> impl Iterator<Item = &Path> {
        let aux = [&self.layers.albedo, &self.layers.normal].into_iter().flatten();
        let files = aux.map(Path::new).filter(|path| path.is_file());
        files.chain([self.input.as_path()])
    }
}
