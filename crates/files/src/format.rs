//! File formats.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{Problem, stream};

/// A format that can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `OpenEXR`.
    Exr,
    /// PNG with 8 or 16 bits.
    Png,
    /// JPEG.
    Jpeg,
}

/// Opens an image for reading: a regular file, or a pipe, which is read whole.
///
/// # Errors
/// If it cannot be opened, is a device, or is a pipe that carries too much.
pub(super) fn open(path: &Path) -> Result<File, Problem> {
    if stream::is_stream(path) { stream::open(path) } else { open_file(path) }
}

/// Opens a regular file for reading. Refuses pipes: opening one would wait for its writer.
///
/// # Errors
/// If the file cannot be opened or is not a regular file.
pub fn open_file(path: &Path) -> Result<File, Problem> {
    if path.metadata().map_err(Problem::Read)?.is_file() {
        return File::open(path).map_err(Problem::Read);
    }
    Err(Problem::NotRegular)
}

impl Format {
    /// Recognizes the format of a file to read by its first bytes.
    ///
    /// # Errors
    /// If the file cannot be read or its format is unknown.
    pub fn of_content(path: &Path) -> Result<Self, Problem> {
        if path.is_dir() {
            return Err(Problem::Format("is a folder and not an image".into()));
        }
        let mut first = Vec::new();
        open(path)?.take(8).read_to_end(&mut first).map_err(Problem::Read)?;
        match first.as_slice() {
            [0x76, 0x2f, 0x31, 0x01, ..] => Ok(Self::Exr),
            [0x89, b'P', b'N', b'G', ..] => Ok(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Ok(Self::Jpeg),
            [] => Err(Problem::Format("is empty".into())),
            _ => Err(Problem::Format("is not an EXR, PNG or JPEG file by its first bytes".into())),
        }
    }

    /// The format of a file to write, by its extension.
    ///
    /// # Errors
    /// If the extension is not .exr, .png, .jpg or .jpeg.
    pub fn of_extension(path: &Path) -> Result<Self, Problem> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match extension.as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            _ => Err(Problem::Format(
                "cannot be written: its name must end in .exr, .png, .jpg or .jpeg".into(),
            )),
        }
    }

    /// The name as people write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exr => "EXR",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
        }
    }

    /// Whether it can store alpha.
    #[must_use]
    pub fn has_alpha(self) -> bool {
        self != Self::Jpeg
    }

    /// Whether it is display-referred: color from 0 to 1 rather than light of any brightness.
    #[must_use]
    pub fn is_display_referred(self) -> bool {
        self != Self::Exr
    }
}
