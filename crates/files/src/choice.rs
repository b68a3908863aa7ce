//! Which layers of an EXR file are colour, albedo and normal: decided from names alone.
//!
//! `Noisy Image` is read rather than the combined layer, and the result goes into the combined
//! layer of the same view layer where there is one.

use std::collections::HashSet;

use super::Problem;
use super::conventions::{self, Convention};
use super::layers::{Layer, Part, layers, list, named, not_three};

/// What the command line says about a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Wish {
    /// Find it by its name.
    #[default]
    Auto,
    /// Do without it.
    Without,
    /// Take the layer of this name.
    Named(String),
}

/// A layer, the three channels of it, and why it was taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pick {
    /// The layer's name as messages show it.
    pub layer: String,
    /// The index of the part.
    pub part: usize,
    /// The indices in the part of red, green and blue, or of x, y and z.
    pub channels: [usize; 3],
    /// What it was recognised as.
    pub reason: &'static str,
}

/// The layers to read and the one to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The noisy colour.
    pub color: Pick,
    /// Where the denoised colour goes.
    pub target: Pick,
    /// The albedo, if there is one.
    pub albedo: Option<Pick>,
    /// The normal, if there is one.
    pub normal: Option<Pick>,
    /// What was passed over, and why or what to do about it.
    pub remarks: Vec<String>,
}

/// Decides which layers to read and which to write.
///
/// # Errors
/// If a named layer is not there or lacks three channels, or no layer can be the colour.
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
    let remarks = others_left(&others);
    Ok(Choice { color, target, albedo, normal, remarks })
}

/// The reason of what the command line names.
const ASKED_FOR: &str = "as asked for";

/// What a file of its own holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Albedo.
    Albedo,
    /// Normals.
    Normal,
}

/// The albedo or normal of a file that holds little else: by name, else the plain or only layer.
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
            "has {n} layers that could be the {what}; give a file with one, or call it \
             `{what}`; its layers are {listed}"
        ),
    })
}

impl Pick {
    fn new(layer: &Layer, channels: [usize; 3], reason: &'static str) -> Self {
        Self { layer: layer.shown().to_string(), part: layer.part, channels, reason }
    }
}

impl Choice {
    /// Does without an albedo and a normal that were found and not asked for, if they do not
    /// pass `check`.
    pub(super) fn leave_out_unusable(&mut self, check: impl Fn(&Pick) -> Result<(), Problem>) {
        for aux in [&mut self.albedo, &mut self.normal] {
            let Some(pick) = aux.as_ref().filter(|pick| pick.reason != ASKED_FOR) else { continue };
            if let Err(problem) = check(pick) {
                self.remarks.push(format!("`{}` is left out: {problem}", pick.layer));
                *aux = None;
            }
        }
    }

    /// One line for a person: what is read, why, and where the result goes. Albedo and normal
    /// may instead come from files, whose names are given.
    #[must_use]
    pub fn explain(&self, albedo_file: Option<&str>, normal_file: Option<&str>) -> String {
        let say = |what: &str, pick: &Option<Pick>, file: Option<&str>| match (pick, file) {
            (_, Some(file)) => format!("{what} from the file {file}"),
            (Some(pick), None) => format!("{what} from `{}` ({})", pick.layer, pick.reason),
            (None, None) => format!("no {what}"),
        };
        let color = &self.color;
        let head = format!(
            "colour from `{}` ({}), written to `{}`",
            color.layer, color.reason, self.target.layer
        );
        let albedo = say("albedo", &self.albedo, albedo_file);
        let normal = say("normal", &self.normal, normal_file);
        let remarks = self.remarks.iter().cloned();
        [head, albedo, normal].into_iter().chain(remarks).collect::<Vec<_>>().join("; ")
    }
}

/// The colour's layer, why it is that, and the others that meet the same convention.
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
        ([only], _) => Ok((only, "the only layer that can be the colour", Vec::new())),
        (_, [only]) => Ok((only, "the only layer with R, G, B and alpha", Vec::new())),
        _ => Err(no_color(layers, rest.len())),
    }
}

/// Where a layer stands that is an albedo or a normal by its name.
fn homes_with_aux(layers: &[Layer]) -> HashSet<&str> {
    let is_aux = |l: &&Layer| {
        conventions::ALBEDO.iter().chain(conventions::NORMAL).any(|convention| l.is(convention))
    };
    layers.iter().filter(is_aux).map(|l| l.pass_name().0).collect()
}

/// Orders layers of one convention, the preferred first: Blender's compositor may have filtered
/// its picture, and a view layer with albedo or normal is the one that is meant to be denoised.
fn rank(homes_with_aux: &HashSet<&str>, color: &Layer) -> (bool, bool) {
    let home = color.pass_name().0;
    (conventions::simple(home) == "composite", !homes_with_aux.contains(home))
}

fn others_left(others: &[&Layer]) -> Vec<String> {
    let listed = list(others.iter().copied());
    match others.len() {
        0 => Vec::new(),
        1 => vec![format!("{listed} is left as it is; name it with --color")],
        _ => vec![format!("{listed} are left as they are; name one with --color")],
    }
}

fn no_color(layers: &[Layer], candidates: usize) -> Problem {
    let gray = layers.iter().any(|l| l.channels.iter().any(|(c, _)| c == "Y"));
    let listed = list(layers);
    Problem::Layers(match candidates {
        0 if gray => format!(
            "has luminance (Y) but no layer with R, G and B, and only three channels can be \
             denoised; its layers are {listed}"
        ),
        0 => format!("has no layer with R, G and B; its layers are {listed}"),
        n => format!(
            "has {n} layers that could be the colour; name one with --color; its layers are \
             {listed}"
        ),
    })
}

/// The first convention that a layer beside the colour meets; for plain colour, any layer.
fn find_aux(layers: &[Layer], table: &[Convention], color: &Layer) -> Option<Pick> {
    let home = color.pass_name().0;
    let near = |l: &&Layer| home.is_empty() || l.pass_name().0 == home;
    table.iter().find_map(|convention| {
        let layer = layers.iter().filter(near).find(|l| l.is(convention) && *l != color)?;
        layer.triple().map(|channels| Pick::new(layer, channels, convention.whose))
    })
}

/// The combined layer of the same view layer, if the colour is its noisy image.
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
