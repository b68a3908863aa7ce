//! The caller's choice of layers.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::Problem;
use super::choice::Wish;
use super::escape::escaped;
use super::layers::{self, Part};
use super::limits::Limits;
use super::stream::is_stream;

/// Which layers to read, and how much at most. Layers that are not named are found by the names that
/// renderers give them.
#[derive(Clone, Debug, Default)]
pub struct LayerChoice {
    /// The layer to denoise.
    pub color: Option<String>,
    /// The layer or the file with the albedo.
    pub albedo: Option<OsString>,
    /// The layer or the file with the normals.
    pub normal: Option<OsString>,
    /// Ignore albedo and normal.
    pub no_aux: bool,
    /// Read the layer that results are written to instead of the noisy one.
    pub finished: bool,
    /// How large the images may be.
    pub limits: Limits,
}

/// What `name` stands for: a layer, or else a file or a pipe.
pub(super) fn wish(
    parts: &[Part],
    name: Option<&OsStr>,
    wanted: &LayerChoice,
) -> Result<(Wish, Option<PathBuf>), Problem> {
    let is_there = |name: &OsStr| Path::new(name).exists() || is_stream(Path::new(name));
    match name {
        _ if wanted.no_aux => Ok((Wish::Without, None)),
        None => Ok((Wish::Auto, None)),
        Some(name) => match layers::named(&layers::layers(parts), &name.to_string_lossy()) {
            Ok(_) => Ok((Wish::Named(name.to_string_lossy().into()), None)),
            Err(_) if is_there(name) => Ok((Wish::Without, Some(name.into()))),
            Err(Problem::Layers(text)) => {
                let name = escaped(&name.to_string_lossy());
                Err(Problem::Layers(format!("{text}, and there is no file `{name}`")))
            }
            Err(problem) => Err(problem),
        },
    }
}
