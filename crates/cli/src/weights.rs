//! Which weights `--weights` and `--quality` mean.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use super::args::EngineArgs;
use super::failure::Failure;
use super::values::QualityArg;
use wgdenoise::{Inputs, Weights};
use wgdenoise::{MainImage, tza};

/// The longest weights file that is read.
const MAX_WEIGHTS_BYTES: u64 = 1 << 30;

/// What there is to denoise, by which weights are chosen from a folder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Given {
    /// What is denoised.
    pub(super) main: MainImage,
    /// What else there is.
    pub(super) inputs: Inputs,
    /// Whether the colour is scene-referred, as in EXR files.
    pub(super) hdr: bool,
    /// Whether albedo and normal are free of noise.
    pub(super) clean: bool,
}

impl Given {
    /// Scene-referred colour with noisy albedo and normal.
    pub(super) const ALL: Self =
        Self { main: MainImage::Color, inputs: Inputs::ALL, hdr: true, clean: false };

    /// Names of Open Image Denoise's weights that can do it, the best first, without their size.
    fn stems(self) -> Vec<String> {
        let prefix = match self.main {
            MainImage::Albedo => return vec!["rt_alb".into()],
            MainImage::Normal => return vec!["rt_nrm".into()],
            MainImage::Color if self.hdr => "rt_hdr",
            MainImage::Color => "rt_ldr",
        };
        let inputs: &[&str] = match self.inputs {
            Inputs { albedo: true, normal: true } if self.clean => &["_calb_cnrm"],
            Inputs { albedo: true, normal: true } => &["_alb_nrm", "_alb", ""],
            Inputs { albedo: true, normal: false } => &["_alb", ""],
            Inputs { albedo: false, .. } => &[""],
        };
        inputs.iter().map(|inputs| format!("{prefix}{inputs}")).collect()
    }
}

/// A network's size in the names of files, the wanted one first.
fn sizes(quality: Option<QualityArg>) -> &'static [&'static str] {
    match quality {
        Some(QualityArg::Fast) => &["_small", ""],
        None | Some(QualityArg::Balanced) => &[""],
        Some(QualityArg::High) => &["_large", ""],
    }
}

/// Where weights come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The program itself.
    BuiltIn(QualityArg),
    /// A file that the user named.
    Named(PathBuf),
    /// The file of a folder that fits what is given.
    Chosen(PathBuf),
}

impl Source {
    pub(super) fn load(&self) -> Result<Weights, Failure> {
        match self {
            Self::BuiltIn(quality) => Ok(Weights::builtin((*quality).into())?),
            Self::Named(file) | Self::Chosen(file) => load(file),
        }
    }

    /// What the user should know of the choice.
    pub(super) fn notice(&self) -> Option<String> {
        let Self::Chosen(file) = self else { return None };
        Some(format!("weights: {}", file.display()))
    }
}

impl EngineArgs {
    /// Where the weights for what is given are.
    pub(super) fn source(&self, given: Given) -> Result<Source, Failure> {
        let Some(path) = &self.weights else {
            return Ok(Source::BuiltIn(self.quality.unwrap_or(QualityArg::Balanced)));
        };
        if path.is_dir() {
            return choose(path, given, self.quality).map(Source::Chosen);
        }
        Ok(Source::Named(path.clone()))
    }

    /// Refuses `--quality` where it has nothing to choose from.
    pub(super) fn check(&self) -> Result<(), Failure> {
        match self.file() {
            Some(file) if self.quality.is_some() => Err(Failure::Usage(format!(
                "--quality chooses among the built-in weights or those of a folder, but --weights \
                 names {}, which is no folder; leave one of them out",
                file.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Those of the file that `--weights` names.
    pub(super) fn named_weights(&self) -> Result<Option<Weights>, Failure> {
        self.file().map(load).transpose()
    }

    /// What `--weights` names, unless it is a folder.
    fn file(&self) -> Option<&Path> {
        self.weights.as_deref().filter(|path| !path.is_dir())
    }
}

/// The file of a folder that fits best.
pub(super) fn choose(
    folder: &Path,
    given: Given,
    quality: Option<QualityArg>,
) -> Result<PathBuf, Failure> {
    let stems = given.stems();
    let names = stems.iter().flat_map(|stem| sizes(quality).iter().map(move |s| stem.clone() + s));
    let files = names.flat_map(|name| ["tza", "safetensors"].map(|e| format!("{name}.{e}")));
    let found = files.map(|file| folder.join(file)).find(|path| path.is_file());
    found.ok_or_else(|| {
        Failure::Work(format!(
            "{}: has {} {}.tza, nor a converted one; the README says where Open Image Denoise's \
             weights are",
            folder.display(),
            if stems.len() == 1 { "no" } else { "none of" },
            stems.join(".tza, ")
        ))
    })
}

/// Reads a file of either format.
pub(super) fn load(path: &Path) -> Result<Weights, Failure> {
    let bytes = read(path)?;
    let weights = if tza::is_tza(path, &bytes) {
        Weights::from_tza(&bytes, &stem(path))
    } else {
        Weights::from_bytes(&bytes)
    };
    weights.map_err(|error| Failure::Work(format!("{}: {error}", path.display())))
}

/// A file's name without its extension.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A whole weights file. Not more than the limit is read, even of what has no length, such as a
/// pipe or a device.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let wrong = |what: String| Failure::Work(format!("{}: {what}", path.display()));
    let unreadable = |error: io::Error| wrong(format!("cannot be read: {error}"));
    let file = File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut bytes = Vec::new();
    if length <= MAX_WEIGHTS_BYTES {
        file.take(MAX_WEIGHTS_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    if length.max(bytes.len() as u64) > MAX_WEIGHTS_BYTES {
        return Err(wrong(format!(
            "is longer than {MAX_WEIGHTS_BYTES} bytes, the most that is accepted of weights"
        )));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stems_follow_what_is_given() {
        let stems = |given: Given| given.stems().join(" ");
        assert_eq!(stems(Given::ALL), "rt_hdr_alb_nrm rt_hdr_alb rt_hdr");
        assert_eq!(stems(Given { clean: true, ..Given::ALL }), "rt_hdr_calb_cnrm");
        let normal = Inputs { albedo: false, normal: true };
        assert_eq!(stems(Given { hdr: false, inputs: normal, ..Given::ALL }), "rt_ldr");
        assert_eq!(stems(Given { main: MainImage::Normal, ..Given::ALL }), "rt_nrm");
    }
}
