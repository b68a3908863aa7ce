//! The caller's choice of layers.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::Problem;
use super::choice::{Wish, Wishes};
use super::escape::escaped;
use super::layers::{self, Layer, Part};
use super::light::LayersWish;
use super::limits::Limits;
use super::motion::MotionWish;
use super::stream::is_stream;

/// Which layers to read, and how much at most. Layers not named are found by the names that
/// renderers give them.
#[derive(Clone, Debug, Default)]
pub struct LayerChoice {
    /// The layer to denoise; by default the color of every view.
    pub color: Option<String>,
    /// The layer or file with the albedo.
    pub albedo: Option<OsString>,
    /// The layer or file with the normals.
    pub normal: Option<OsString>,
    /// Ignore albedo and normal.
    pub no_aux: bool,
    /// Further light layers to denoise.
    pub layers: Option<LayersWish>,
    /// The motion vectors; none by default.
    pub motion: MotionWish,
    /// Read the layer that results are written to instead of the noisy one.
    pub finished: bool,
    /// How large images may be.
    pub limits: Limits,
}

/// Files or pipes that stand in for layers.
#[derive(Clone, Debug, Default)]
pub(super) struct Files {
    pub(super) albedo: Option<PathBuf>,
    pub(super) normal: Option<PathBuf>,
}

impl LayerChoice {
    /// Resolves the names for a file with these parts: to layers, or else to files.
    pub(super) fn wishes(&self, parts: &[Part]) -> Result<(Wishes, Files), Problem> {
        let layers = layers::layers(parts);
        let (albedo, albedo_file) = self.wish(&layers, self.albedo.as_deref())?;
        let (normal, normal_file) = self.wish(&layers, self.normal.as_deref())?;
        let (color, further) = (self.color.clone(), self.layers.clone());
        let motion = self.motion.clone();
        let wishes = Wishes { color, albedo, normal, layers: further, motion };
        Ok((wishes, Files { albedo: albedo_file, normal: normal_file }))
    }

    fn wish(
        &self,
        layers: &[Layer],
        name: Option<&OsStr>,
    ) -> Result<(Wish, Option<PathBuf>), Problem> {
        let is_there = |path: &Path| path.exists() || is_stream(path);
        let Some(name) = name.filter(|_| !self.no_aux) else {
            return Ok((if self.no_aux { Wish::Without } else { Wish::Auto }, None));
        };
        let text = name.to_string_lossy();
        match layers::named(layers, &text) {
            Ok(_) => Ok((Wish::Named(text.into()), None)),
            Err(_) if is_there(Path::new(name)) => Ok((Wish::Without, Some(name.into()))),
            Err(Problem::Layers(what)) => {
                let name = escaped(&text);
                Err(Problem::Layers(format!("{what}, and there is no file `{name}`")))
            }
            Err(problem) => Err(problem),
        }
    }
}
