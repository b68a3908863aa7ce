//! Parses the words of a command line into a request.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::{CommandFactory, Parser};

use crate::args::{Cli, Command, DenoiseArgs, MeasureArgs};
use crate::console::Verbosity;
use crate::failure::{Failure, shown};
use crate::groups::{
    ChoiceArgs, DeviceArgs, LayerArgs, LightArgs, LimitArgs, NetworkArgs, WritingArgs,
};
use crate::request::{
    Bench, Compare, Convert, Denoise, DeviceChoice, Info, Preview, Report, Request, WeightsChoice,
    Writing,
};
use crate::values::QualityArg;
use wgdenoise::Quality;
use wgdenoise_files::inputs::Source;
use wgdenoise_files::{Identity, LayerChoice, LayersWish, Limits, MotionWish, is_standard};

/// Parses the words of a command line, the program's name first. Prints help, versions and words
/// that the grammar refuses, and ends the process.
///
/// # Errors
/// If the words contradict each other or the files they name.
pub(crate) fn parse(words: &[OsString]) -> Result<Request, Failure> {
    if let Some(word) = words.get(1)
        && let Some(command) = misspelled(word)
    {
        let word = shown(Path::new(word));
        return Err(Failure::Usage(format!(
            "`{word}` is neither a file nor a command; did you mean `wgdenoise {command}`?"
        )));
    }
    request(Cli::parse_from(words))
}

/// Parses the words of a command line that denoises, the program's name first.
///
/// # Errors
/// If the grammar refuses the words, or they contradict each other or the files they name.
pub(crate) fn parse_denoise(words: &[OsString]) -> Result<Denoise, Failure> {
    let cli = Cli::try_parse_from(words).map_err(|error| Failure::Usage(reason(&error)))?;
    match cli.command {
        None => denoise(cli.denoise),
        Some(_) => Err(Failure::Usage("a host denoises and runs no other command".into())),
    }
}

/// The sentence of a refusal, without the usage advice below it.
fn reason(error: &clap::Error) -> String {
    let text = error.to_string();
    let sentence = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
    sentence.lines().map(str::trim).collect::<Vec<_>>().join(" ")
}

/// The command that a word naming no file was probably meant to be.
fn misspelled(word: &OsStr) -> Option<String> {
    let text = word.to_str()?.to_lowercase();
    let is_name = text.chars().all(char::is_alphanumeric) && !Path::new(word).exists();
    let cli = Cli::command();
    let names = cli.get_subcommands().map(clap::Command::get_name).chain(["help"]);
    let distance = |name: &&str| strsim::damerau_levenshtein(name, &text);
    let nearest = names.filter(|_| is_name).min_by_key(distance)?;
    let near = distance(&nearest) <= nearest.len() / 3 && word != nearest;
    near.then(|| nearest.to_string())
}

fn request(cli: Cli) -> Result<Request, Failure> {
    Ok(match cli.command {
        None => Request::Denoise(denoise(cli.denoise)?),
        Some(Command::Info(args)) => {
            let layers = with_light(layers(args.layers), &args.light);
            Request::Info(Info { input: args.input, layers, json: args.json })
        }
        Some(Command::Preview(args)) => Request::Preview(Preview {
            input: args.input,
            output: args.output,
            layer: args.layer,
            exposure: args.exposure,
            limits: limits(args.limits),
            writing: writing(&args.writing, false),
        }),
        Some(Command::Compare(args)) => Request::Compare(Compare {
            image: args.image,
            reference: args.reference,
            layers: LayerChoice {
                color: args.color,
                no_aux: true,
                finished: true,
                limits: limits(args.limits),
                ..LayerChoice::default()
            },
            json: args.json,
        }),
        Some(Command::Devices(args)) => Request::Devices { json: args.json },
        Some(Command::Bench(args)) => Request::Bench(bench(args.measure, args.json)?),
        Some(Command::Profile(args)) => Request::Profile(bench(args.measure, false)?),
        Some(Command::Report(args)) => Request::Report(Report {
            noisy: args.noisy,
            reference: args.reference,
            layers: layers(args.layers),
            runs: args.runs,
            device: device(args.device, None),
            out: args.out,
            force: args.force,
            json: args.json,
        }),
        Some(Command::Convert(args)) => {
            Request::Convert(Convert { input: args.input, output: args.output, force: args.force })
        }
        Some(Command::Completions { shell }) => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "wgdenoise", &mut script);
            Request::Print(script)
        }
        Some(Command::Man { command }) => Request::Print(manual(command.as_deref())?),
    })
}

/// The manual page of the program or of one of its commands, in roff.
fn manual(name: Option<&str>) -> Result<Vec<u8>, Failure> {
    let mut program = Cli::command();
    program.build();
    let command = match name {
        None => Some(&program),
        Some(name) => program.find_subcommand(name),
    };
    let unknown = || Failure::Usage(format!("{}: no such command", name.unwrap_or_default()));
    let mut page = Vec::new();
    let rendered = clap_mangen::Man::new(command.ok_or_else(unknown)?.clone()).render(&mut page);
    rendered.map_err(|error| Failure::Work(format!("the manual page: {error}")))?;
    Ok(page)
}

fn denoise(args: DenoiseArgs) -> Result<Denoise, Failure> {
    let (inputs, output) = inputs_and_output(args.files, args.in_place)?;
    let weights = chosen_weights(&args.network, &args.choice)?;
    let motion = match (args.temporal, args.motion) {
        (None, _) => MotionWish::Without,
        (Some(_), None) => MotionWish::Auto,
        (Some(_), Some(name)) => MotionWish::Named(name),
    };
    Ok(Denoise {
        verbosity: match (args.quiet, args.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        },
        inputs,
        output,
        frames: args.frames,
        layers: LayerChoice { motion, ..with_light(layers(args.layers), &args.light) },
        temporal: usize::from(args.temporal.unwrap_or(0)),
        weights,
        device: device(args.device, args.network.precision.map(Into::into)),
        input_scale: args.choice.input_scale,
        skip_existing: args.skip_existing,
        format: args.format.map(Into::into),
        overlap: !args.no_overlap,
        alpha: args.alpha,
        verify: args.verify,
        exposure: args.exposure,
        writing: writing(&args.writing, args.in_place),
    })
}

/// Splits IN from OUT, which `--in-place` may leave out.
fn inputs_and_output(
    mut files: Vec<PathBuf>,
    in_place: bool,
) -> Result<(Vec<PathBuf>, Option<PathBuf>), Failure> {
    if in_place && files.split_last().is_some_and(|(last, others)| is_input(last, others)) {
        return Ok((files, None));
    }
    match (files.pop(), files.as_slice()) {
        (Some(output), [_, ..]) => Ok((files, Some(output))),
        (Some(only), []) => Err(Failure::Usage(without_output(&only)?)),
        (None, _) => Err(Failure::Usage("name IN and OUT, or a command; see --help".into())),
    }
}

/// Whether the last file of an `--in-place` run is another IN rather than OUT: it is the only one,
/// or it names files that exist and none of which is another IN.
fn is_input(last: &Path, others: &[PathBuf]) -> bool {
    let named_before = || others.iter().any(|other| Identity::of(other) == Identity::of(last));
    match Source::of(last) {
        _ if others.is_empty() => true,
        Ok(Source::File(path)) => path.is_file() && !named_before(),
        Ok(Source::Glob(_)) => true,
        _ => false,
    }
}

/// Explains why one word is not a complete command line.
fn without_output(word: &Path) -> Result<String, Failure> {
    let name = shown(word);
    Ok(match Source::of(word)? {
        Source::File(path) if !path.exists() && !is_standard(&path) => {
            format!("`{name}` is neither a file nor a command; see --help")
        }
        _ => format!("`{name}` has no output; write wgdenoise {name} OUT, or see --help"),
    })
}

fn chosen_weights(network: &NetworkArgs, choice: &ChoiceArgs) -> Result<WeightsChoice, Failure> {
    if let Some(limit) = choice.budget {
        return Ok(WeightsChoice::Budget { limit, recalibrate: choice.recalibrate });
    }
    match named_weights(network)? {
        WeightsChoice::Folder { path, quality, .. } => {
            Ok(WeightsChoice::Folder { path, quality, prefilter: choice.prefilter })
        }
        WeightsChoice::File(file) if choice.prefilter => Err(Failure::Usage(format!(
            "--prefilter needs a folder with weights for albedo and normal, but --weights names \
             {}, which is not a folder",
            shown(&file)
        ))),
        other => Ok(other),
    }
}

fn named_weights(args: &NetworkArgs) -> Result<WeightsChoice, Failure> {
    let quality = args.quality.map(Quality::from);
    match &args.weights {
        None => {
            let tier = args.quality.unwrap_or(QualityArg::Balanced);
            Ok(WeightsChoice::BuiltIn(tier.into()))
        }
        Some(path) if path.is_dir() => {
            Ok(WeightsChoice::Folder { path: path.clone(), quality, prefilter: false })
        }
        Some(path) if quality.is_none() => Ok(WeightsChoice::File(path.clone())),
        Some(path) => Err(Failure::Usage(format!(
            "--quality chooses among the built-in weights or those in a folder, but --weights \
             names {}, which is not a folder; leave one of them out",
            shown(path)
        ))),
    }
}

fn bench(args: MeasureArgs, json: bool) -> Result<Bench, Failure> {
    let (pixels, most) = (u64::from(args.width) * u64::from(args.height), Limits::default().pixels);
    if pixels > most {
        return Err(Failure::Usage(format!(
            "--width and --height make {pixels} pixels, and at most {most} can be measured"
        )));
    }
    Ok(Bench {
        width: args.width,
        height: args.height,
        runs: args.runs,
        weights: named_weights(&args.network)?,
        device: device(args.device, args.network.precision.map(Into::into)),
        json,
    })
}

fn device(args: DeviceArgs, precision: Option<wgdenoise::Precision>) -> DeviceChoice {
    DeviceChoice {
        adapter: args.adapter,
        precision,
        memory: args.memory,
        tile: args.tile,
        timeout: args.timeout,
        kernels: args.kernels.into(),
        skip_clean: !args.no_skip,
    }
}

fn layers(args: LayerArgs) -> LayerChoice {
    LayerChoice {
        color: args.color,
        albedo: args.albedo,
        normal: args.normal,
        no_aux: args.no_aux,
        limits: limits(args.limits),
        ..LayerChoice::default()
    }
}

fn with_light(layers: LayerChoice, args: &LightArgs) -> LayerChoice {
    LayerChoice { layers: args.layers.as_deref().map(LayersWish::parse), ..layers }
}

fn limits(args: LimitArgs) -> Limits {
    args.max_pixels.map_or_else(Limits::default, |pixels| Limits { pixels })
}

fn writing(args: &WritingArgs, in_place: bool) -> Writing {
    Writing { force: args.force, in_place, parents: args.parents }
}

#[cfg(test)]
#[path = "parse_test.rs"]
mod tests;
