//! Albedo and normals from separate files.

use std::path::Path;

use super::exr::ExrFile;
use super::features::{self, Kind};
use super::format::Format;
use super::limits::Limits;
use super::window::{self, Place};
use super::{FileError, Problem, ldr};
use wgdenoise::Image;

/// The albedo of an EXR file's albedo or only layer, or of a PNG or JPEG, fitted to the color; and
/// a notice if it had to be moved.
pub(super) fn albedo(
    path: &Path,
    color: &Place,
    limits: Limits,
) -> Result<(Image, Option<String>), FileError> {
    fitting(path, Kind::Albedo, color, limits).map_err(|problem| problem.at(path))
}

/// Normals, likewise; PNG and JPEG files hold them as `n·0.5+0.5`.
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
