//! The caller's choice of layers.

use std::path::Path;

use super::Problem;
use super::choice::{Wish, Wishes};
use super::escape::escaped;
use super::layers::{self, Layer, Part};
use super::light::LayersWish;
use super::limits::Limits;

/// Which layers to read, and how much at most. Layers that are not named are found by the names that
/// renderers give them.
#[derive(Clone, Debug, Default)]
pub struct LayerChoice {
    /// The layer to denoise; by default the color of every view.
    pub color: Option<String>,
    /// The layer or the file with the albedo.
    pub albedo: Option<String>,
    /// The layer or the file with the normals.
    pub normal: Option<String>,
    /// Ignore albedo and normal.
    pub no_aux: bool,
    /// Further layers of light to denoise along.
    pub layers: Option<LayersWish>,
    /// Read the layer that results are written to instead of the noisy one.
    pub finished: bool,
    /// How large the images may be.
    pub limits: Limits,
}

/// Files that stand in for layers.
#[derive(Clone, Debug, Default)]
pub(super) struct Files {
    pub(super) albedo: Option<String>,
    pub(super) normal: Option<String>,
}

impl LayerChoice {
    /// What the names stand for in a file with these parts: layers, or else files.
    pub(super) fn wishes(&self, parts: &[Part]) -> Result<(Wishes, Files), Problem> {
        let layers = layers::layers(parts);
        let (albedo, albedo_file) = self.wish(&layers, self.albedo.as_deref())?;
        let (normal, normal_file) = self.wish(&layers, self.normal.as_deref())?;
        let (color, further) = (self.color.clone(), self.layers.clone());
        let wishes = Wishes { color, albedo, normal, layers: further };
        Ok((wishes, Files { albedo: albedo_file, normal: normal_file }))
    }

    fn wish(
        &self,
        layers: &[Layer],
        name: Option<&str>,
    ) -> Result<(Wish, Option<String>), Problem> {
        match name {
            _ if self.no_aux => Ok((Wish::Without, None)),
            None => Ok((Wish::Auto, None)),
            Some(name) => match layers::named(layers, name) {
                Ok(_) => Ok((Wish::Named(name.into()), None)),
                Err(_) if Path::new(name).exists() => Ok((Wish::Without, Some(name.into()))),
                Err(Problem::Layers(text)) => Err(Problem::Layers(format!(
                    "{text}, and there is no file `{}`",
                    escaped(name)
                ))),
                Err(problem) => Err(problem),
            },
        }
    }
}
