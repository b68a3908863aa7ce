//! The caller's choice of layers.

use std::path::Path;

use super::Problem;
use super::choice::Wish;
use super::layers::{self, Part};
use super::limits::Limits;

/// Which layers to read, and how much at most. Layers that are not named are found by the names that
/// renderers give them.
#[derive(Clone, Debug, Default)]
pub struct LayerChoice {
    /// The layer to denoise.
    pub color: Option<String>,
    /// The layer or the file with the albedo.
    pub albedo: Option<String>,
    /// The layer or the file with the normals.
    pub normal: Option<String>,
    /// Ignore albedo and normal.
    pub no_aux: bool,
    /// Read the layer that results are written to instead of the noisy one.
    pub finished: bool,
    /// How large the images may be.
    pub limits: Limits,
}

/// What `name` stands for: a layer, or else a file.
pub(super) fn wish(
    parts: &[Part],
    name: Option<&str>,
    wanted: &LayerChoice,
) -> Result<(Wish, Option<String>), Problem> {
    match name {
        _ if wanted.no_aux => Ok((Wish::Without, None)),
        None => Ok((Wish::Auto, None)),
        Some(name) => match layers::named(&layers::layers(parts), name) {
            Ok(_) => Ok((Wish::Named(name.into()), None)),
            Err(_) if Path::new(name).exists() => Ok((Wish::Without, Some(name.into()))),
            Err(Problem::Layers(text)) => {
                Err(Problem::Layers(format!("{text}, and there is no file `{name}`")))
            }
            Err(problem) => Err(problem),
        },
    }
}
