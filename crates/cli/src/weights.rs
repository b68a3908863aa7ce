//! Finds an image's weights, and converts those of Open Image Denoise.

use std::io::Write as _;
use std::path::PathBuf;

use crate::console::Console;
use crate::failure::{Failure, shown};
use crate::request::{Convert, WeightsChoice};
use wgdenoise::{MainImage, Quality, Weights, tza};
use wgdenoise_files::weights::{Subject, choose, load, read, stem};
use wgdenoise_files::{Identity, Problem, check_place, replace};

/// The source of an image's weights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Built into the program.
    BuiltIn(Quality),
    /// The file that the user named.
    Named(PathBuf),
    /// The file in a folder that fits the image.
    Chosen(PathBuf),
}

impl Source {
    pub(crate) fn load(&self) -> Result<Weights, Failure> {
        match self {
            Self::BuiltIn(quality) => Ok(Weights::builtin(*quality)?),
            Self::Named(file) | Self::Chosen(file) => Ok(load(file)?),
        }
    }

    /// What the user should know about the choice.
    pub(crate) fn notice(&self) -> Option<String> {
        let Self::Chosen(file) = self else { return None };
        Some(format!("weights: {}", shown(file)))
    }
}

impl WeightsChoice {
    /// The source of the weights for a subject; `None` if a time budget chooses.
    pub(crate) fn source(&self, subject: Subject) -> Result<Option<Source>, Failure> {
        Ok(match self {
            Self::BuiltIn(quality) => Some(Source::BuiltIn(*quality)),
            Self::File(file) => Some(Source::Named(file.clone())),
            Self::Folder { path, quality, prefilter } => {
                let subject = Subject { clean: *prefilter, ..subject };
                Some(Source::Chosen(choose(path, subject, *quality)?))
            }
            Self::Budget { .. } => None,
        })
    }

    /// The weights that denoise albedo and normals first, if wanted.
    pub(crate) fn prefilter(&self) -> Result<Option<[Weights; 2]>, Failure> {
        let Self::Folder { path, quality, prefilter: true } = self else { return Ok(None) };
        let load = |main| {
            let subject = Subject { main, ..Subject::ALL };
            choose(path, subject, *quality).and_then(|file| load(&file))
        };
        Ok(Some([load(MainImage::Albedo)?, load(MainImage::Normal)?]))
    }
}

/// Converts a weights file of Open Image Denoise to wgdenoise's format, after checking it.
pub(crate) fn convert(request: &Convert, console: &Console) -> Result<(), Failure> {
    let Convert { input, output, force } = request;
    check_output(request)?;
    let bytes = read(input)?;
    let of_input = |error| Failure::of(input, error);
    let converted = tza::to_safetensors(&bytes, &stem(input)).map_err(of_input)?;
    let checked = Weights::from_bytes(&converted).map_err(of_input)?;
    replace(output, *force, |out| out.write_all(&converted).map_err(Problem::Write))?;
    let metadata = checked.metadata();
    console.notice(&format!(
        "wrote {}: `{}`, {}, transfer function {}",
        shown(output),
        metadata.name,
        metadata.inputs,
        metadata.transfer_function.name()
    ));
    Ok(())
}

/// Refuses an output that is the input, cannot be written, or would be read as the wrong format.
fn check_output(Convert { input, output, force }: &Convert) -> Result<(), Failure> {
    if Identity::of(input) == Identity::of(output) {
        return Err(Failure::of(output, "is also the input; give another OUT"));
    }
    if tza::is_tza(output, &[]) {
        let what = "would be taken for a TZA file; end its name in .safetensors";
        return Err(Failure::of(output, what));
    }
    Ok(check_place(output, *force)?)
}
