//! Which images are denoised and where each result goes, checked before any work is done.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf, is_separator};

use crate::failure::{Failure, shown};
use crate::inputs::{Sequence, Source};
use crate::request::{Denoise, Writing};
use wgdenoise_files::{Format, Identity, LayerChoice, Problem};

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
    if request.frames.is_some() && !sources.iter().any(Source::is_sequence) {
        let what =
            "--frames needs an IN with a place for the frame number, such as beauty.####.exr";
        return Err(Failure::Usage(what.into()));
    }
    // A missing input is reported before a missing folder.
    let files: Vec<_> = sources
        .iter()
        .map(|source| source.files(request.frames.as_ref()))
        .collect::<Result<_, _>>()?;
    let target = match &request.output {
        Some(output) => Target::of(output, &sources, request.writing.parents)?,
        None => Target::Input,
    };
    let mut jobs = Vec::new();
    for (source, files) in sources.iter().zip(files) {
        jobs.extend(jobs_of(source, files, &target, request)?);
    }
    check_conflicts(&mut jobs, request.writing.in_place)?;
    if request.exposure.is_some() {
        jobs.iter().try_for_each(Job::check_exposure)?;
    }
    for job in &jobs {
        prepare_output(&job.output, job.replace, request.writing)?;
    }
    Ok(jobs)
}

/// The jobs of one IN, from its files and their frames.
fn jobs_of(
    source: &Source,
    files: Vec<(PathBuf, Option<u32>)>,
    target: &Target,
    request: &Denoise,
) -> Result<Vec<Job>, Failure> {
    let layers = Layers::of(&request.layers, source.is_sequence())?;
    layers.check(&files.iter().filter_map(|(_, frame)| *frame).collect::<Vec<_>>())?;
    let job = |(input, frame): (PathBuf, Option<u32>)| Job {
        output: target.path(&input, frame),
        layers: layers.at(frame),
        replace: request.writing.force,
        input,
    };
    Ok(files.into_iter().map(job).collect())
}

/// Checks that an output can be written, and creates its folder if asked to.
pub(crate) fn prepare_output(path: &Path, replace: bool, writing: Writing) -> Result<(), Failure> {
    // An output that will be refused leaves no folder behind.
    format(path)?;
    if let Some(folder) = path.parent().filter(|_| writing.parents) {
        let failed = |error| Failure::of(folder, format_args!("cannot be created: {error}"));
        fs::create_dir_all(folder).map_err(failed)?;
    }
    wgdenoise_files::check_output(path, replace)?;
    Ok(())
}

fn format(output: &Path) -> Result<Format, Failure> {
    let usage = |problem: Problem| Failure::Usage(problem.at(output).to_string());
    Format::of_extension(output).map_err(usage)
}

/// Refuses outputs that are inputs or belong to two inputs. With `in_place`, an output may be its own
/// input.
fn check_conflicts(jobs: &mut [Job], in_place: bool) -> Result<(), Failure> {
    let readers = readers(jobs);
    let mut written = HashMap::new();
    for (index, job) in jobs.iter_mut().enumerate() {
        let identity = Identity::of(&job.output);
        if let Some(readers) = readers.get(&identity) {
            let other = readers.iter().find(|(reader, _)| *reader != index);
            let (_, input) = other.unwrap_or(&readers[0]);
            job.overwrite(input, in_place, other.is_none())?;
        }
        if let Some(other) = written.insert(identity, job.input.clone()) {
            let (other, input) = (shown(&other), shown(&job.input));
            let what = format!("is the output of both {other} and {input}; denoise one by one");
            return Err(Failure::of(&job.output, what));
        }
    }
    Ok(())
}

/// For each file, the jobs that read it and the path by which they do.
fn readers(jobs: &[Job]) -> HashMap<Identity, Vec<(usize, PathBuf)>> {
    let mut readers: HashMap<_, Vec<_>> = HashMap::new();
    for (index, job) in jobs.iter().enumerate() {
        for file in job.files() {
            readers.entry(Identity::of(file)).or_default().push((index, file.to_path_buf()));
        }
    }
    readers
}

impl Job {
    /// The files it reads.
    fn files(&self) -> impl Iterator<Item = &Path> {
        let aux = [&self.layers.albedo, &self.layers.normal].into_iter().flatten();
        let files = aux.map(Path::new).filter(|path| path.is_file());
        [self.input.as_path()].into_iter().chain(files)
    }

    /// Refuses `--exposure` for an EXR file.
    fn check_exposure(&self) -> Result<(), Failure> {
        if format(&self.output)?.is_display_referred() {
            return Ok(());
        }
        let what = "--exposure changes PNG and JPEG only; EXR keeps the light as it was rendered";
        Err(Failure::Usage(format!("{}: {what}", shown(&self.output))))
    }

    /// Refuses an image that would change its format by replacing itself.
    fn check_extension(&self) -> Result<(), Failure> {
        let named = format(&self.output)?;
        match Format::of_content(&self.input) {
            Ok(content) if content != named => {
                let (content, named) = (content.name(), named.name());
                let what = format!("is {content}, but its name means {named}; give another OUT");
                Err(Failure::of(&self.input, what))
            }
            // An input that cannot be read is reported when its turn comes.
            _ => Ok(()),
        }
    }

    /// Lets the output replace `input` if that is asked for, and `only` this job reads it.
    fn overwrite(&mut self, input: &Path, in_place: bool, only: bool) -> Result<(), Failure> {
        let own = only && Identity::of(&self.input) == Identity::of(input);
        if own && in_place {
            self.replace = true;
            return self.check_extension();
        }
        let advice = if own { ", or --in-place to replace it" } else { "" };
        let what = format!("is also the input {}; give another OUT{advice}", shown(input));
        Err(Failure::of(&self.output, what))
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
    /// Each result in place of its input.
    Input,
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
            (Self::Input, _) => input.to_path_buf(),
        }
    }
}
