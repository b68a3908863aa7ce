//! Finds the weights file in a folder that fits an image, and reads weights files.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::{FileError, Problem, open_file};
use wgdenoise::{Inputs, MainImage, Quality, Weights, tza};

/// The longest weights file that is read.
const MAX_BYTES: u64 = 1 << 30;

/// What is denoised, which decides among the weights in a folder.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Which image is denoised.
    pub main: MainImage,
    /// The images given besides the main one.
    pub inputs: Inputs,
    /// Whether the color is scene-referred, as in EXR files.
    pub hdr: bool,
    /// Whether albedo and normal are free of noise.
    pub clean: bool,
}

impl Subject {
    /// Scene-referred color with noisy albedo and normal.
    pub const ALL: Self =
        Self { main: MainImage::Color, inputs: Inputs::ALL, hdr: true, clean: false };

    /// Names of Open Image Denoise's weights that fit, best first, without their size.
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

/// Network sizes in file names, preferred first.
fn sizes(quality: Option<Quality>) -> &'static [&'static str] {
    match quality {
        Some(Quality::Fast) => &["_small", ""],
        None | Some(Quality::Balanced) => &[""],
        Some(Quality::High) => &["_large", ""],
    }
}

/// Picks the file in a folder that fits best, by the names of Open Image Denoise's files.
///
/// # Errors
/// If no file of the folder fits.
pub fn choose(
    folder: &Path,
    subject: Subject,
    quality: Option<Quality>,
) -> Result<PathBuf, FileError> {
    let stems = subject.stems();
    let names = stems.iter().flat_map(|stem| sizes(quality).iter().map(move |s| stem.clone() + s));
    let files = names.flat_map(|name| ["tza", "safetensors"].map(|e| format!("{name}.{e}")));
    let found = files.map(|file| folder.join(file)).find(|path| path.is_file());
    found.ok_or_else(|| {
        let none = if stems.len() == 1 { "no" } else { "none of" };
        let list = stems.join(".tza, ");
        Problem::Format(format!(
            "has {none} {list}.tza, nor a converted one; docs/weights.md tells where to get Open \
             Image Denoise's weights"
        ))
        .at(folder)
    })
}

/// Reads a weights file of either format.
///
/// # Errors
/// If it cannot be read, is longer than 1 GiB, or is not a weights file.
pub fn load(path: &Path) -> Result<Weights, FileError> {
    let bytes = read(path)?;
    let weights = if tza::is_tza(path, &bytes) {
        Weights::from_tza(&bytes, &stem(path))
    } else if is_safetensors(&bytes) {
        Weights::from_bytes(&bytes)
    } else {
        return Err(Problem::Format(NO_WEIGHTS.into()).at(path));
    };
    weights.map_err(|error| Problem::Format(error.to_string()).at(path))
}

const NO_WEIGHTS: &str = "is not a weights file, which is a .safetensors file in wgdenoise's format \
                          or a .tza file of Open Image Denoise";

/// Whether a file starts like safetensors: the length of the header, then its JSON.
fn is_safetensors(bytes: &[u8]) -> bool {
    bytes.get(8) == Some(&b'{')
}

/// A file name without its extension, which identifies Open Image Denoise's files.
#[must_use]
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Reads a whole weights file. Reads at most 1 GiB, even if the file grows meanwhile.
///
/// # Errors
/// If it cannot be read or is longer.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let read = || {
        let file = open_file(path)?;
        let length = file.metadata().map_err(Problem::Read)?.len();
        let mut bytes = Vec::new();
        if length <= MAX_BYTES {
            file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(Problem::Read)?;
        }
        if length.max(bytes.len() as u64) > MAX_BYTES {
            let what = format!("is longer than {MAX_BYTES} bytes, the most for weights");
            return Err(Problem::TooLarge(what));
        }
        Ok(bytes)
    };
    read().map_err(|problem| problem.at(path))
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
