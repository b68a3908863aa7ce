//! Decides which images to denoise and where each result goes; checks all before any work is done.

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf, is_separator};

use crate::failure::{Failure, shown};
use crate::gaps;
use crate::request::{Denoise, Writing};
use crate::temporal::Number;
use wgdenoise_files::frames::{self, Frames, PLAIN_CHARACTERS};
use wgdenoise_files::inputs::{Sequence, Source};
use wgdenoise_files::{Format, Identity, LayerChoice, Problem, is_standard, is_stream};

/// The plan for a request.
#[derive(Debug)]
pub(crate) struct Plan {
    /// The images, in order.
    pub(crate) jobs: Vec<Job>,
    /// How many others are done already.
    pub(crate) skipped: usize,
    /// What a user should know, one sentence each.
    pub(crate) notices: Vec<String>,
}

/// One image to denoise.
#[derive(Debug)]
pub(crate) struct Job {
    /// A file, a pipe, or `-` for standard input.
    pub(crate) input: PathBuf,
    /// A file, or `-` for standard output.
    pub(crate) output: PathBuf,
    /// The output's format.
    pub(crate) format: Format,
    pub(crate) layers: LayerChoice,
    /// Whether the output may exist already.
    pub(crate) replace: bool,
    /// Whether the output is written; if not, only other frames need the result.
    pub(crate) writes: bool,
    /// Its position in a sequence.
    pub(crate) number: Option<Number>,
}

/// Plans a request.
///
/// # Errors
/// If the request contradicts itself, an input is missing, or an output cannot be written, would
/// replace an input, or belongs to two inputs.
pub(crate) fn plan(request: &Denoise) -> Result<Plan, Failure> {
    let sources =
        request.inputs.iter().map(|input| Source::of(input)).collect::<Result<Vec<_>, _>>()?;
    if request.frames.is_some() && !sources.iter().any(Source::is_sequence) {
        let what =
            "--frames needs an IN with a place for the frame number, such as beauty.####.exr";
        return Err(Failure::Usage(what.into()));
    }
    if request.temporal > 0 && !sources.iter().all(Source::is_sequence) {
        let what =
            "--temporal needs an IN with a place for the frame number, such as beauty.####.exr";
        return Err(Failure::Usage(what.into()));
    }
    let mut jobs = jobs(request, &sources)?;
    check_conflicts(&mut jobs, request.writing.in_place)?;
    check_streams(&jobs)?;
    if request.exposure.is_some() {
        jobs.iter().try_for_each(Job::check_exposure)?;
    }
    let skipped = skip(&mut jobs, |job| request.skip_existing && job.output.is_file());
    keep_needed(&mut jobs, request.temporal);
    for job in jobs.iter().filter(|job| job.writes) {
        prepare_output(&job.output, job.replace, request.writing)?;
    }
    let mut notices = left_out(request, &sources)?;
    notices.extend(gaps::notices(request, &sources, &written(&jobs))?);
    Ok(Plan { jobs, skipped, notices })
}

/// Marks jobs that are done as not to be written; returns how many.
fn skip(jobs: &mut [Job], is_done: impl Fn(&Job) -> bool) -> usize {
    let done = jobs.iter_mut().filter(|job| job.writes && is_done(job));
    done.map(|job| job.writes = false).count()
}

/// The frames that are written.
fn written(jobs: &[Job]) -> Vec<Number> {
    jobs.iter().filter(|job| job.writes).filter_map(|job| job.number).collect()
}

/// Keeps the jobs that write, and those within `reach` frames of one that does.
fn keep_needed(jobs: &mut Vec<Job>, reach: usize) {
    let written = written(jobs);
    let is_near = |number: Number| {
        written.iter().any(|other| {
            let distance = other.frame.abs_diff(number.frame);
            other.sequence == number.sequence && distance <= reach as u64
        })
    };
    jobs.retain(|job| job.writes || job.number.is_some_and(is_near));
}

/// The jobs of a request, in order.
fn jobs(request: &Denoise, sources: &[Source]) -> Result<Vec<Job>, Failure> {
    // Report a missing input before a missing folder.
    let files: Vec<_> =
        sources.iter().map(|source| files(source, request)).collect::<Result<_, _>>()?;
    let target = match &request.output {
        Some(output) => Target::of(output, sources, request.writing.parents)?,
        None => Target::Input,
    };
    let mut jobs = Vec::new();
    for (index, (source, files)) in sources.iter().zip(files).enumerate() {
        jobs.extend(jobs_of((index, source), files, &target, request)?);
    }
    Ok(jobs)
}

/// The files of an IN and their frames, including those that only `--temporal` needs.
fn files(source: &Source, request: &Denoise) -> Result<Vec<(PathBuf, Option<i64>)>, Failure> {
    let wanted = source.files(request.frames.as_ref())?;
    if request.temporal == 0 {
        return Ok(wanted);
    }
    let reach = request.temporal as u64;
    let is_near =
        |frame: i64| wanted.iter().filter_map(|(_, f)| *f).any(|f| f.abs_diff(frame) <= reach);
    let mut all = source.files(None)?;
    all.retain(|(_, frame)| frame.is_some_and(is_near));
    Ok(all)
}

/// The jobs of one IN, given its files and their frames.
fn jobs_of(
    (index, source): (usize, &Source),
    files: Vec<(PathBuf, Option<i64>)>,
    target: &Target,
    request: &Denoise,
) -> Result<Vec<Job>, Failure> {
    let frames: Vec<_> = files.iter().filter_map(|(_, frame)| *frame).collect();
    let layers = Layers::of(&request.layers, source.is_sequence(), &Frames(frames))?;
    let job = |(input, frame): (PathBuf, Option<i64>)| {
        let output = target.path(&input, frame)?;
        let format = output_format(&output, &input, request.format)?;
        let (layers, replace) = (layers.at(frame), request.writing.force);
        let wanted = request.frames.as_ref().zip(frame);
        let writes = wanted.is_none_or(|(Frames(wanted), frame)| wanted.contains(&frame));
        let number = frame.map(|frame| Number { sequence: index, frame });
        Ok(Job { input, output, format, layers, replace, writes, number })
    };
    files.into_iter().map(job).collect()
}

/// The format of a result: by the output's name or, on standard output, `wanted` or else the
/// input's.
fn output_format(output: &Path, input: &Path, wanted: Option<Format>) -> Result<Format, Failure> {
    match (is_standard(output), wanted) {
        (true, Some(format)) => Ok(format),
        (true, None) => Ok(Format::of_content(input).map_err(|problem| problem.at(input))?),
        (false, None) => format(output),
        (false, Some(_)) => {
            let what = "--format is for standard output; elsewhere the name of OUT decides";
            Err(Failure::Usage(format!("{}: {what}", shown(output))))
        }
    }
}

/// Refuses a pipe among several images: it could not be read again for each.
fn check_streams(jobs: &[Job]) -> Result<(), Failure> {
    let streams = jobs.iter().flat_map(Job::inputs).find(|path| is_stream(path));
    match streams {
        Some(stream) if jobs.len() > 1 => {
            let what = "a pipe is read for one image, and there are several";
            Err(Failure::Usage(format!("{}: {what}", shown(stream))))
        }
        _ => Ok(()),
    }
}

/// Notices about files that sequences leave out, unless frames were chosen.
fn left_out(request: &Denoise, sources: &[Source]) -> Result<Vec<String>, Failure> {
    let whole = sources.iter().filter(|_| request.frames.is_none());
    whole.filter_map(|source| Some(source.left_out().transpose()?.map_err(Failure::from))).collect()
}

/// Checks that an output can be written; creates its folder if asked to.
pub(crate) fn prepare_output(path: &Path, replace: bool, writing: Writing) -> Result<(), Failure> {
    if let Some(folder) = path.parent().filter(|_| writing.parents) {
        let failed = |error| Failure::of(folder, format_args!("cannot be created: {error}"));
        fs::create_dir_all(folder).map_err(failed)?;
    }
    wgdenoise_files::check_place(path, replace)?;
    Ok(())
}

fn format(output: &Path) -> Result<Format, Failure> {
    let pipe = if is_stream(output) { "; give - for standard output" } else { "" };
    let usage = |problem: Problem| Failure::Usage(format!("{}{pipe}", problem.at(output)));
    Format::of_extension(output).map_err(usage)
}

/// Refuses outputs that are inputs or belong to two inputs. With `in_place`, an output may be its
/// own input.
fn check_conflicts(jobs: &mut [Job], in_place: bool) -> Result<(), Failure> {
    let readers = readers(jobs);
    let mut written = HashMap::new();
    let writes = |job: &Job| job.writes && !is_standard(&job.output);
    for (index, job) in jobs.iter_mut().enumerate().filter(|(_, job)| writes(job)) {
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

/// For each file, the jobs that read it and the path they read it by.
fn readers(jobs: &[Job]) -> HashMap<Identity, Vec<(usize, PathBuf)>> {
    let mut readers: HashMap<_, Vec<_>> = HashMap::new();
    for (index, job) in jobs.iter().enumerate() {
        for file in job.inputs() {
            readers.entry(Identity::of(file)).or_default().push((index, file.to_path_buf()));
        }
    }
    readers
}

impl Job {
    /// The files and pipes that the job reads.
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let aux = [&self.layers.albedo, &self.layers.normal].into_iter().flatten();
        let aux = aux.map(Path::new).filter(|path| path.is_file() || is_stream(path));
        [self.input.as_path()].into_iter().chain(aux)
    }

    /// Refuses `--exposure` for an EXR file.
    fn check_exposure(&self) -> Result<(), Failure> {
        if self.format.is_display_referred() {
            return Ok(());
        }
        let what = "--exposure changes PNG and JPEG only; EXR keeps the light as it was rendered";
        Err(Failure::Usage(format!("{}: {what}", shown(&self.output))))
    }

    /// Refuses an image that would change its format by replacing itself.
    fn check_extension(&self) -> Result<(), Failure> {
        match Format::of_content(&self.input) {
            Ok(content) if content != self.format => {
                let (content, named) = (content.name(), self.format.name());
                let what = format!("is {content}, but its name means {named}; give another OUT");
                Err(Failure::of(&self.input, what))
            }
            // An input that cannot be read is reported when its turn comes.
            _ => Ok(()),
        }
    }

    /// Lets the output replace `input` if asked to, and if `only` this job reads it.
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
    albedo: Option<BTreeMap<i64, PathBuf>>,
    normal: Option<BTreeMap<i64, PathBuf>>,
}

impl Layers {
    /// Finds the frames' files. Refuses frames without one.
    fn of(choice: &LayerChoice, in_sequence: bool, frames: &Frames) -> Result<Self, Failure> {
        let files = |name: &Option<OsString>| {
            let name = name.as_ref().filter(|_| in_sequence);
            let sequence = name.map(|name| Sequence::of(Path::new(name))).transpose()?.flatten();
            sequence.map(|sequence| sequence.files(Some(frames))).transpose()
        };
        let (albedo, normal) = (files(&choice.albedo)?, files(&choice.normal)?);
        Ok(Self { choice: choice.clone(), albedo, normal })
    }

    /// The layers of one image.
    fn at(&self, frame: Option<i64>) -> LayerChoice {
        let file = |files: &Option<BTreeMap<i64, PathBuf>>| {
            files.as_ref()?.get(&frame?).cloned().map(PathBuf::into_os_string)
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
    /// A single file, for the only result.
    File(PathBuf),
    /// Files named by frame number.
    Sequence(Sequence),
    /// A folder, in which results have the names of their inputs.
    Folder(PathBuf),
    /// Each result replaces its input.
    Input,
}

impl Target {
    fn of(path: &Path, sources: &[Source], parents: bool) -> Result<Self, Failure> {
        let ends_as_folder = path.to_string_lossy().ends_with(is_separator);
        if path.is_dir() || (ends_as_folder && parents) {
            return Ok(Self::Folder(path.to_path_buf()));
        }
        let usage = |what: &str| Err(Failure::Usage(format!("{}: {what}", shown(path))));
        let name = path.file_name().unwrap_or_default();
        let file = || Ok(Self::File(path.with_file_name(frames::plain(name))));
        match sources {
            [Source::File(_)] if is_standard(path) => return Ok(Self::File(path.to_path_buf())),
            _ if is_standard(path) => return usage("standard output takes the result of one file"),
            // A file may really be named like a sequence, and so may its result.
            [Source::File(input)] if input.exists() && Sequence::of(input)?.is_some() => {
                return Ok(Self::File(path.to_path_buf()));
            }
            [Source::File(_)] if !ends_as_folder && !frames::has_padded_place(name) => {
                return file();
            }
            _ => {}
        }
        match (Sequence::of(path)?, sources) {
            (Some(sequence), [Source::Sequence(_)]) => Ok(Self::Sequence(sequence)),
            (Some(_), _) => usage(&format!(
                "has a place for a frame number, which needs exactly one IN that has one too\
                 {PLAIN_CHARACTERS}"
            )),
            (None, [Source::Sequence(_)]) => usage(
                "needs a place for the frame number as IN has, such as clean.####.exr, or must be \
                 an existing folder",
            ),
            (None, _) if parents => Ok(Self::Folder(path.to_path_buf())),
            (None, _) => Err(Failure::of(
                path,
                "the results need a folder, and this one does not exist; give --parents to create \
                 it",
            )),
        }
    }

    /// The output of an input.
    fn path(&self, input: &Path, frame: Option<i64>) -> Result<PathBuf, Failure> {
        Ok(match (self, frame) {
            (Self::Sequence(sequence), Some(frame)) => sequence.file(frame),
            (Self::Sequence(_), None) => unreachable!("an OUT with frames has an IN with frames"),
            (Self::File(path), _) => path.clone(),
            _ if is_standard(input) => {
                let what = "standard input has no name; name OUT, or give - for standard output";
                return Err(Failure::Usage(format!("{}: {what}", shown(input))));
            }
            (Self::Folder(folder), _) => folder.join(input.file_name().unwrap_or_default()),
            (Self::Input, _) => input.to_path_buf(),
        })
    }
}
