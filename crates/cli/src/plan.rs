//! Which images are denoised and where each result goes, checked before any work is done.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf, is_separator};

use crate::failure::{Failure, shown};
use crate::inputs::{Sequence, Source};
use crate::request::{Denoise, Writing};
use wgdenoise_files::{Format, Identity, LayerChoice};

/// One image to denoise.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) layers: LayerChoice,
    /// Whether the output may exist already.
    pub(crate) replace: bool,
}

/// The jobs of a request, in their order.
///
/// # Errors
/// If the request contradicts itself, an input is missing, or an output cannot be written, would
/// replace an input, or is that of two inputs.
pub(crate) fn jobs(request: &Denoise) -> Result<Vec<Job>, Failure> {
    let sources =
        request.inputs.iter().map(|input| Source::of(input)).collect::<Result<Vec<_>, _>>()?;
    let is_sequence = |source: &Source| matches!(source, Source::Sequence(_));
    if request.frames.is_some() && !sources.iter().any(is_sequence) {
        return Err(Failure::Usage(
            "--frames needs an IN with a place for the frame number, such as beauty.####.exr"
                .into(),
        ));
    }
    let target = Target::of(&request.output, &sources, request.writing.parents)?;
    let mut jobs = Vec::new();
    for source in &sources {
        let files = source.files(request.frames.as_ref())?;
        let layers = Layers::of(&request.layers, is_sequence(source))?;
        layers.check(&files.iter().filter_map(|(_, frame)| *frame).collect::<Vec<_>>())?;
        for (input, frame) in files {
            let output = target.path(&input, frame);
            let (layers, replace) = (layers.at(frame), request.writing.force);
            jobs.push(Job { input, output, layers, replace });
        }
    }
    check_conflicts(&mut jobs, request.writing.in_place)?;
    for job in &jobs {
        let format = prepare_output(&job.output, job.replace, request.writing)?;
        if request.exposure.is_some() && !format.is_display_referred() {
            return Err(Failure::of(
                &job.output,
                "--exposure changes PNG and JPEG only; EXR keeps the light as it was rendered",
            ));
        }
    }
    Ok(jobs)
}

/// Checks that an output can be written, and creates its folder if asked to.
pub(crate) fn prepare_output(
    path: &Path,
    replace: bool,
    writing: Writing,
) -> Result<Format, Failure> {
    // An output that will be refused leaves no folder behind.
    Format::of_extension(path).map_err(|problem| problem.at(path))?;
    if let Some(folder) = path.parent().filter(|_| writing.parents) {
        let failed = |error| Failure::of(folder, format_args!("cannot be created: {error}"));
        fs::create_dir_all(folder).map_err(failed)?;
    }
    Ok(wgdenoise_files::check_output(path, replace)?)
}

/// Refuses outputs that are inputs or belong to two inputs.
fn check_conflicts(jobs: &mut [Job], in_place: bool) -> Result<(), Failure> {
    let mut read = HashMap::new();
    for job in jobs.iter() {
        for input in job.files() {
            read.insert(Identity::of(input), input.to_path_buf());
        }
    }
    let mut written = HashMap::new();
    for Job { input, output, replace, .. } in jobs {
        let identity = Identity::of(output);
        if identity == Identity::of(input) {
            if !in_place {
                let what = "is also the input {}; give another OUT, or --in-place to replace it";
                return Err(Failure::of(output, what.replace("{}", &shown(input))));
            }
            *replace = true;
        } else if let Some(input) = read.get(&identity) {
            let what = format!("is also the input {}; give another OUT", shown(input));
            return Err(Failure::of(output, what));
        }
        if let Some(other) = written.insert(identity, input.clone()) {
            let (other, input) = (shown(&other), shown(input));
            let what = format!("is the output of both {other} and {input}; denoise one by one");
            return Err(Failure::of(output, what));
        }
    }
    Ok(())
}

impl Job {
    /// The files it reads.
    fn files(&self) -> impl Iterator<Item = &Path> {
        let aux = [&self.layers.albedo, &self.layers.normal].into_iter().flatten();
        let files = aux.map(Path::new).filter(|path| path.is_file());
        files.chain([self.input.as_path()])
    }
}

/// The layers of a request. Next to a sequence, albedo and normals may be sequences too.
#[derive(Debug)]
struct Layers {
    choice: LayerChoice,
    albedo: Option<Sequence>,
    normal: Option<Sequence>,
}

impl Layers {
    fn of(choice: &LayerChoice, in_sequence: bool) -> Result<Self, Failure> {
        let sequence = |name: &Option<String>| match name {
            Some(name) if in_sequence => Sequence::of(Path::new(name)),
            _ => Ok(None),
        };
        let (albedo, normal) = (sequence(&choice.albedo)?, sequence(&choice.normal)?);
        Ok(Self { choice: choice.clone(), albedo, normal })
    }

    /// Refuses frames without a file.
    fn check(&self, frames: &[u32]) -> Result<(), Failure> {
        let sequences = [&self.albedo, &self.normal].into_iter().flatten();
        sequences.into_iter().try_for_each(|sequence| sequence.check(frames))
    }

    /// The layers of one image.
    fn at(&self, frame: Option<u32>) -> LayerChoice {
        let file = |sequence: &Option<Sequence>| {
            let file = sequence.as_ref().zip(frame).map(|(sequence, frame)| sequence.file(frame));
            file.map(|file| file.to_string_lossy().into_owned())
        };
        let choice = self.choice.clone();
        LayerChoice {
            albedo: file(&self.albedo).or(choice.albedo),
            normal: file(&self.normal).or(choice.normal),
            ..choice
        }
    }
}

/// Where results go.
#[derive(Debug)]
enum Target {
    /// The only result.
    File(PathBuf),
    /// Each result by its frame number.
    Sequence(Sequence),
    /// Each result by the name of its input.
    Folder(PathBuf),
}

impl Target {
    fn of(path: &Path, sources: &[Source], parents: bool) -> Result<Self, Failure> {
        let ends_as_folder = path.to_string_lossy().ends_with(is_separator);
        if path.is_dir() || (ends_as_folder && parents) {
            return Ok(Self::Folder(path.to_path_buf()));
        }
        let usage = |what: &str| Err(Failure::Usage(format!("{}: {what}", shown(path))));
        match (Sequence::of(path)?, sources) {
            (Some(sequence), [Source::Sequence(_)]) => Ok(Self::Sequence(sequence)),
            // A file may really have such a name, and so may its result.
            (Some(_), [Source::File(input)])
                if input.exists() && Sequence::of(input)?.is_some() =>
            {
                Ok(Self::File(path.to_path_buf()))
            }
            (Some(_), _) => {
                usage("has a place for a frame number, which needs exactly one IN that has one too")
            }
            (None, [Source::Sequence(_)]) => usage(
                "needs a place for the frame number as IN has, such as clean.####.exr, or must be \
                 an existing folder",
            ),
            (None, [Source::File(_)]) if !ends_as_folder => Ok(Self::File(path.to_path_buf())),
            (None, _) if parents => Ok(Self::Folder(path.to_path_buf())),
            (None, _) => Err(Failure::of(
                path,
                "the results need a folder, and this one does not exist; give --parents to create \
                 it",
            )),
        }
    }

    /// The output of an input.
    fn path(&self, input: &Path, frame: Option<u32>) -> PathBuf {
        match (self, frame) {
            (Self::Sequence(sequence), Some(frame)) => sequence.file(frame),
            (Self::Sequence(_), None) => unreachable!("an OUT with frames has an IN with frames"),
            (Self::Folder(folder), _) => folder.join(input.file_name().unwrap_or_default()),
            (Self::File(path), _) => path.clone(),
        }
    }
}
