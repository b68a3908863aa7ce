//! Albedo and normals from separate files.

use std::path::Path;

use super::exr::ExrFile;
use super::features::{self, Kind};
use super::format::Format;
use super::limits::Limits;
use super::window::{self, Place};
use super::{FileError, Problem, ldr};
use wgdenoise::Image;

/// Reads the albedo from an EXR file's albedo or only layer, or from a PNG or JPEG, and fits it to
/// the color. Returns a notice if it had to be moved.
pub(super) fn albedo(
    path: &Path,
    color: &Place,
    limits: Limits,
) -> Result<(Image, Option<String>), FileError> {
    fitting(path, Kind::Albedo, color, limits).map_err(|problem| problem.at(path))
}

/// Reads normals likewise; PNG and JPEG files store them as `n·0.5+0.5`.
pub(super) fn normal(
    path: &Path,
    color: &Place,
    limits: Limits,
) -> Result<(Image, Option<String>), FileError> {
    fitting(path, Kind::Normal, color, limits).map_err(|problem| problem.at(path))
}

fn fitting(
    path: &Path,
    kind: Kind,
    color: &Place,
    limits: Limits,
) -> Result<(Image, Option<String>), Problem> {
    let (image, place) = read(path, kind, limits)?;
    window::fit(image, &path.to_string_lossy(), &place, color)
}

fn read(path: &Path, kind: Kind, limits: Limits) -> Result<(Image, Place), Problem> {
    let image = match (Format::of_content(path)?, kind) {
        (Format::Exr, _) => {
            let file = ExrFile::open(path, limits)?;
            let pick = features::choose_single(&file.parts(), kind)?;
            let image = file.read(&[&pick], &[])?.0.remove(0);
            return Ok((image, Place::of(&file.headers()[pick.part()])));
        }
        (_, Kind::Albedo) => ldr::LdrFile::read(path, limits)?.1,
        (_, Kind::Normal) => ldr::read_normals(path, limits)?,
    };
    let place = Place::sized(image.size());
    Ok((image, place))
}
