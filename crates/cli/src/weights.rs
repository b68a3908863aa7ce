//! Weights files: which one an image needs, reading it, and converting those of Open Image Denoise.

use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::console::Console;
use crate::failure::{Failure, shown};
use crate::request::{Convert, WeightsChoice};
use wgdenoise::{Inputs, MainImage, Quality, Weights, tza};
use wgdenoise_files::{Identity, Problem, check_place, replace};

/// The longest weights file that is read.
const MAX_WEIGHTS_BYTES: u64 = 1 << 30;

/// What is denoised; weights in a folder are chosen by it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subject {
    pub(crate) main: MainImage,
    /// The images next to the main one.
    pub(crate) inputs: Inputs,
    /// Whether the color is scene-referred, as in EXR files.
    pub(crate) hdr: bool,
    /// Whether albedo and normal are free of noise.
    pub(crate) clean: bool,
}

impl Subject {
    /// Scene-referred color with noisy albedo and normal.
    pub(crate) const ALL: Self =
        Self { main: MainImage::Color, inputs: Inputs::ALL, hdr: true, clean: false };

    /// Names of Open Image Denoise's weights that fit, the best first, without their size.
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

/// A network's size in file names, the wanted one first.
fn sizes(quality: Option<Quality>) -> &'static [&'static str] {
    match quality {
        Some(Quality::Fast) => &["_small", ""],
        None | Some(Quality::Balanced) => &[""],
        Some(Quality::High) => &["_large", ""],
    }
}

/// Where an image's weights come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The program itself.
    BuiltIn(Quality),
    /// The file that the user named.
    Named(PathBuf),
    /// The file of a folder that fits the image.
    Chosen(PathBuf),
}

impl Source {
    pub(crate) fn load(&self) -> Result<Weights, Failure> {
        match self {
            Self::BuiltIn(quality) => Ok(Weights::builtin(*quality)?),
            Self::Named(file) | Self::Chosen(file) => load(file),
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

    /// The weights that denoise albedo and normals first, if they are wanted.
    pub(crate) fn prefilter(&self) -> Result<Option<[Weights; 2]>, Failure> {
        let Self::Folder { path, quality, prefilter: true } = self else { return Ok(None) };
        let load = |main| load(&choose(path, Subject { main, ..Subject::ALL }, *quality)?);
        Ok(Some([load(MainImage::Albedo)?, load(MainImage::Normal)?]))
    }
}

/// The file of a folder that fits best.
fn choose(folder: &Path, subject: Subject, quality: Option<Quality>) -> Result<PathBuf, Failure> {
    let stems = subject.stems();
    let names = stems.iter().flat_map(|stem| sizes(quality).iter().map(move |s| stem.clone() + s));
    let files = names.flat_map(|name| ["tza", "safetensors"].map(|e| format!("{name}.{e}")));
    let found = files.map(|file| folder.join(file)).find(|path| path.is_file());
    found.ok_or_else(|| {
        let none = if stems.len() == 1 { "no" } else { "none of" };
        let list = stems.join(".tza, ");
        Failure::of(
            folder,
            format_args!(
                "has {none} {list}.tza, nor a converted one; docs/weights.md tells where to get Open \
                 Image Denoise's weights"
            ),
        )
    })
}

/// Reads a weights file of either format.
pub(crate) fn load(path: &Path) -> Result<Weights, Failure> {
    let bytes = read(path)?;
    if tza::is_tza(path, &bytes) {
        return Weights::from_tza(&bytes, &stem(path)).map_err(|error| Failure::of(path, error));
    }
    if !is_safetensors(&bytes) {
        return Err(Failure::of(
            path,
            "is not a weights file, which is a .safetensors file in wgdenoise's format or a .tza \
             file of Open Image Denoise",
        ));
    }
    Weights::from_bytes(&bytes).map_err(|error| Failure::of(path, error))
}

/// Whether a file starts like safetensors: the length of the header, then its JSON.
fn is_safetensors(bytes: &[u8]) -> bool {
    bytes.get(8) == Some(&b'{')
}

/// A file's name without its extension.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A whole weights file. No more than the limit is read, even if the file grows meanwhile.
fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let unreadable = |error: io::Error| Failure::of(path, format_args!("cannot be read: {error}"));
    let file = wgdenoise_files::open_file(path).map_err(|problem| problem.at(path))?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut bytes = Vec::new();
    if length <= MAX_WEIGHTS_BYTES {
        file.take(MAX_WEIGHTS_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    if length.max(bytes.len() as u64) > MAX_WEIGHTS_BYTES {
        let what = format!("is longer than {MAX_WEIGHTS_BYTES} bytes, the most for weights");
        return Err(Failure::of(path, what));
    }
    Ok(bytes)
}

/// Writes a weights file of Open Image Denoise as one of wgdenoise's format, after checking it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stems_follow_the_subject() {
        let stems = |subject: Subject| subject.stems().join(" ");
        assert_eq!(stems(Subject::ALL), "rt_hdr_alb_nrm rt_hdr_alb rt_hdr");
        assert_eq!(stems(Subject { clean: true, ..Subject::ALL }), "rt_hdr_calb_cnrm");
        let normal = Inputs { albedo: false, normal: true };
        assert_eq!(stems(Subject { hdr: false, inputs: normal, ..Subject::ALL }), "rt_ldr");
        assert_eq!(stems(Subject { main: MainImage::Normal, ..Subject::ALL }), "rt_nrm");
    }
}
