//! What the caller asks for.

use std::path::Path;

use super::Problem;
use super::choice::Wish;
use super::layers::{self, Part};
use super::limits::Limits;

/// What to read: names of layers where the file's own names do not tell, and how much at most.
#[derive(Clone, Debug, Default)]
pub struct LayerChoice {
    /// The layer to denoise.
    pub color: Option<String>,
    /// The layer or the file with the albedo.
    pub albedo: Option<String>,
    /// The layer or the file with the normals.
    pub normal: Option<String>,
    /// Leave albedo and normal out even where they are there.
    pub no_aux: bool,
    /// Read the layer that results are written to instead of the noisy one.
    pub finished: bool,
    /// How large the images may be.
    pub limits: Limits,
}

/// A layer's name stays a name; anything else must be a file.
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
            Err(_) if Path::new(name).is_file() => Ok((Wish::Without, Some(name.into()))),
            Err(Problem::Layers(text)) => {
                Err(Problem::Layers(format!("{text}, and there is no file `{name}`")))
            }
            Err(problem) => Err(problem),
        },
    }
}
