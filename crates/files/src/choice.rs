//! Which layers of an EXR file are color, albedo and normal: decided from names alone.
//!
//! `Noisy Image` is read rather than the combined layer, and the result goes into the combined
//! layer of the same view layer where there is one.

use std::collections::HashSet;

use super::Problem;
use super::conventions::{self, Convention};
use super::escape::escaped;
use super::layers::{Layer, Part, layers, list, named, not_three};
use super::selection::Selection;

/// How to choose a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Wish {
    /// By the names that renderers use.
    #[default]
    Auto,
    /// Not at all.
    Without,
    /// The layer of this name.
    Named(String),
}

/// Three channels of a layer, and why the layer was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pick {
    /// The layer's name as messages show it.
    pub layer: String,
    /// Index of the part.
    pub part: usize,
    /// Indices within the part of red, green and blue, or of x, y and z.
    pub channels: [usize; 3],
    /// What the layer was recognized as.
    pub reason: &'static str,
}

/// The layers to read, and the one to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The noisy color.
    pub color: Pick,
    /// Where the denoised color goes.
    pub target: Pick,
    /// The albedo, if any.
    pub albedo: Option<Pick>,
    /// The normal, if any.
    pub normal: Option<Pick>,
    /// Other layers that could be the color.
    pub other_colors: Vec<String>,
    /// Why a layer that was found is not used, a sentence each.
    pub left_out: Vec<String>,
}

/// Decides which layers to read and which to write.
///
/// # Errors
/// If a named layer is missing or lacks three channels, or no layer can be the color.
pub fn choose(
    parts: &[Part],
    color: Option<&str>,
    albedo: &Wish,
    normal: &Wish,
) -> Result<Choice, Problem> {
    let layers = layers(parts);
    let (noisy, reason, others) = match color {
        Some(name) => (named(&layers, name)?, ASKED_FOR, Vec::new()),
        None => find_color(&layers)?,
    };
    let channels = noisy.rgb().or_else(|| noisy.xyz()).ok_or_else(|| not_three(noisy))?;
    let color = Pick::new(noisy, channels, reason);
    let target = combined_beside(&layers, noisy).unwrap_or_else(|| color.clone());
    let aux = |wish: &Wish, table| match wish {
        Wish::Without => Ok(None),
        Wish::Auto => Ok(find_aux(&layers, table, noisy)),
        Wish::Named(name) => {
            let layer = named(&layers, name)?;
            let channels = layer.triple().ok_or_else(|| not_three(layer))?;
            Ok(Some(Pick::new(layer, channels, ASKED_FOR)))
        }
    };
    let (albedo, normal) = (aux(albedo, conventions::ALBEDO)?, aux(normal, conventions::NORMAL)?);
    let other_colors = others.into_iter().map(|l| l.shown().to_string()).collect();
    Ok(Choice { color, target, albedo, normal, other_colors, left_out: Vec::new() })
}

/// The reason for a layer that the caller named.
const ASKED_FOR: &str = "as asked for";

/// What a separate file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Albedo.
    Albedo,
    /// Normals.
    Normal,
}

/// The albedo or normal of a separate file: by its name, or else the plain or only layer.
///
/// # Errors
/// If no layer can be it.
pub fn choose_single(parts: &[Part], kind: Kind) -> Result<Pick, Problem> {
    let layers = layers(parts);
    let table = match kind {
        Kind::Albedo => conventions::ALBEDO,
        Kind::Normal => conventions::NORMAL,
    };
    let by_name = table.iter().find_map(|c| layers.iter().find(|l| l.is(c)));
    let usable: Vec<_> = layers.iter().filter(|l| l.triple().is_some()).collect();
    let plain = usable.iter().find(|l| l.name.is_empty() || usable.len() == 1).copied();
    let layer = by_name.or(plain).ok_or_else(|| not_single(&layers, kind, usable.len()))?;
    let channels = layer.triple().ok_or_else(|| not_three(layer))?;
    Ok(Pick::new(layer, channels, "from a file of its own"))
}

fn not_single(layers: &[Layer], kind: Kind, candidates: usize) -> Problem {
    let what = if kind == Kind::Albedo { "albedo" } else { "normal" };
    let listed = list(layers);
    Problem::Layers(match candidates {
        0 => format!("has no layer with three channels; its layers are {listed}"),
        n => format!(
            "has {n} layers that could be the {what}; give a file with one, or name the layer \
             `{what}`; its layers are {listed}"
        ),
    })
}

impl Pick {
    fn new(layer: &Layer, channels: [usize; 3], reason: &'static str) -> Self {
        Self { layer: layer.shown().to_string(), part: layer.part, channels, reason }
    }

    /// Channels that the caller named.
    pub(super) fn named(layer: &str, part: usize, channels: [usize; 3]) -> Self {
        Self { layer: layer.to_string(), part, channels, reason: ASKED_FOR }
    }
}

impl Choice {
    /// Drops an albedo or normal that was found by its name and does not pass `check`. One that the
    /// caller named stays.
    pub(super) fn leave_out_unusable(&mut self, check: impl Fn(&Pick) -> Result<(), Problem>) {
        for aux in [&mut self.albedo, &mut self.normal] {
            let Some(pick) = aux.as_ref().filter(|pick| pick.reason != ASKED_FOR) else { continue };
            if let Err(problem) = check(pick) {
                self.left_out.push(format!("`{}` is left out: {problem}", escaped(&pick.layer)));
                *aux = None;
            }
        }
    }

    /// The choice as a user reads it. Albedo and normal may come from files instead, whose names
    /// are given.
    #[must_use]
    pub fn selection(&self, albedo_file: Option<&str>, normal_file: Option<&str>) -> Selection {
        let aux = |pick: &Option<Pick>, file: Option<&str>| pick.is_some() || file.is_some();
        Selection {
            color: self.color.layer.clone(),
            target: self.target.layer.clone(),
            albedo: aux(&self.albedo, albedo_file),
            normal: aux(&self.normal, normal_file),
            explanation: self.explain(albedo_file, normal_file),
            other_colors: self.other_colors.clone(),
            left_out: self.left_out.clone(),
        }
    }

    fn explain(&self, albedo_file: Option<&str>, normal_file: Option<&str>) -> [String; 3] {
        let aux = |what: &str, pick: &Option<Pick>, file: Option<&str>| match (pick, file) {
            (_, Some(file)) => format!("{what} from the file {}", escaped(file)),
            (Some(pick), None) => {
                format!("{what} from `{}` ({})", escaped(&pick.layer), pick.reason)
            }
            (None, None) => format!("no {what}"),
        };
        let [color, target] = [&self.color, &self.target].map(|pick| escaped(&pick.layer));
        let reason = self.color.reason;
        [
            format!("color from `{color}` ({reason}), written to `{target}`"),
            aux("albedo", &self.albedo, albedo_file),
            aux("normal", &self.normal, normal_file),
        ]
    }
}

/// The color's layer, the reason, and the other layers of the same convention.
fn find_color(layers: &[Layer]) -> Result<(&Layer, &'static str, Vec<&Layer>), Problem> {
    let has_rgb = |l: &&Layer| l.rgb().is_some();
    let homes = homes_with_aux(layers);
    for convention in conventions::COLOR {
        let meeting = || layers.iter().filter(has_rgb).filter(|l| l.is(convention));
        if let Some(layer) = meeting().min_by_key(|l| rank(&homes, l)) {
            return Ok((layer, convention.whose, meeting().filter(|l| *l != layer).collect()));
        }
    }
    let rest: Vec<_> = layers.iter().filter(has_rgb).filter(|l| !l.is_known_data()).collect();
    let has_alpha = |l: &&&Layer| l.find(["r", "g", "a"]).is_some();
    let with_alpha: Vec<_> = rest.iter().filter(has_alpha).collect();
    match (rest.as_slice(), with_alpha.as_slice()) {
        ([only], _) => Ok((only, "the only layer that can be the color", Vec::new())),
        (_, [only]) => Ok((only, "the only layer with R, G, B and alpha", Vec::new())),
        _ => Err(no_color(layers, rest.len())),
    }
}

/// The view layers that have an albedo or a normal by name.
fn homes_with_aux(layers: &[Layer]) -> HashSet<&str> {
    let is_aux = |l: &&Layer| {
        conventions::ALBEDO.iter().chain(conventions::NORMAL).any(|convention| l.is(convention))
    };
    layers.iter().filter(is_aux).map(|l| l.pass_name().0).collect()
}

/// Orders layers of one convention, the preferred first: a view layer with albedo or normal is the
/// one meant for denoising, and Blender's compositor may have filtered its output.
fn rank(homes_with_aux: &HashSet<&str>, color: &Layer) -> (bool, bool) {
    let home = color.pass_name().0;
    (conventions::simple(home) == "composite", !homes_with_aux.contains(home))
}

fn no_color(layers: &[Layer], candidates: usize) -> Problem {
    let gray = layers.iter().any(|l| l.channels.iter().any(|(c, _)| c == "Y"));
    let listed = list(layers);
    match candidates {
        0 if gray => Problem::Layers(format!(
            "has luminance (Y) but no layer with R, G and B, and only three channels can be \
             denoised; its layers are {listed}"
        )),
        0 => Problem::Layers(format!("has no layer with R, G and B; its layers are {listed}")),
        n => Problem::AmbiguousColor(format!(
            "has {n} layers that could be the color; its layers are {listed}"
        )),
    }
}

/// The first convention that a layer next to the color meets; for plain color, any layer.
fn find_aux(layers: &[Layer], table: &[Convention], color: &Layer) -> Option<Pick> {
    let home = color.pass_name().0;
    let near = |l: &&Layer| home.is_empty() || l.pass_name().0 == home;
    table.iter().find_map(|convention| {
        let layer = layers.iter().filter(near).find(|l| l.is(convention) && *l != color)?;
        layer.triple().map(|channels| Pick::new(layer, channels, convention.whose))
    })
}

/// The combined layer of the same view layer, if the color is its noisy image.
fn combined_beside(layers: &[Layer], noisy: &Layer) -> Option<Pick> {
    let (home, pass) = noisy.pass_name();
    let is_combined = |l: &&Layer| {
        let (prefix, name) = l.pass_name();
        prefix == home && conventions::simple(name) == "combined"
    };
    let combined = layers.iter().filter(|_| conventions::simple(pass) == "noisyimage");
    let combined = combined.into_iter().find(is_combined)?;
    combined.rgb().map(|channels| Pick::new(combined, channels, "Blender's combined pass"))
}

#[cfg(test)]
#[path = "choice_test.rs"]
mod tests;
