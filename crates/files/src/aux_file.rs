//! Albedo and normals from separate files.

use std::path::Path;

use super::exr::ExrFile;
use super::features::{self, Kind};
use super::format::Format;
use super::limits::Limits;
use super::{FileError, Problem, ldr, window};
use wgdenoise::Image;

/// An albedo of the color's size: from an EXR file's albedo or only layer, or a PNG or JPEG.
pub(super) fn albedo(path: &Path, size: (u32, u32), limits: Limits) -> Result<Image, FileError> {
    read(path, Kind::Albedo, limits).and_then(|image| fitting(image, size)).map_err(|p| p.at(path))
}

/// Normals of the color's size; PNG and JPEG files hold them as `n·0.5+0.5`.
pub(super) fn normal(path: &Path, size: (u32, u32), limits: Limits) -> Result<Image, FileError> {
    read(path, Kind::Normal, limits).and_then(|image| fitting(image, size)).map_err(|p| p.at(path))
}

fn read(path: &Path, kind: Kind, limits: Limits) -> Result<Image, Problem> {
    match (Format::of_content(path)?, kind) {
        (Format::Exr, _) => {
            let file = ExrFile::open(path, limits)?;
            let pick = features::choose_single(&file.parts(), kind)?;
            Ok(file.read(&[&pick], &[])?.0.remove(0))
        }
        (_, Kind::Albedo) => ldr::LdrFile::read(path, limits).map(|(_, image)| image),
        (_, Kind::Normal) => ldr::read_normals(path, limits),
    }
}

fn fitting(image: Image, size: (u32, u32)) -> Result<Image, Problem> {
    if image.size() == size { Ok(image) } else { Err(window::other_size(image.size(), size)) }
}
