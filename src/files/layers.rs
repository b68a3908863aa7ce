//! Which channels of an EXR file are colour, albedo and normal: decided from names alone.
//!
//! A channel's full name is split at its last dot into a layer and a letter; a channel without
//! a dot belongs to the layer named like its part. `Noisy Image` is read rather than the
//! combined layer, and the result goes into the combined layer where there is one.

use super::Problem;
use super::conventions::{self, Convention};

/// One part of a file, by its names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// The part's `name` attribute.
    pub name: Option<String>,
    /// The full names of its channels, in the file's order.
    pub channels: Vec<String>,
}

/// Channels of one part that share everything before the last dot of their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The shared name; empty for the plain channels of a file with a single part.
    pub name: String,
    /// The index of the part that holds it.
    pub part: usize,
    /// What follows the last dot, and the channel's index in the part.
    pub channels: Vec<(String, usize)>,
}

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
}

/// All layers of a file, in the order in which it names them.
#[must_use]
pub fn layers(parts: &[Part]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, names) in parts.iter().enumerate() {
        let plain = if parts.len() > 1 { names.name.as_deref().unwrap_or("") } else { "" };
        for (channel, full) in names.channels.iter().enumerate() {
            let (name, letter) = split(full, plain);
            let entry = (letter.to_string(), channel);
            match layers.iter_mut().find(|l| l.part == part && l.name == name) {
                Some(layer) => layer.channels.push(entry),
                None => layers.push(Layer { name: name.into(), part, channels: vec![entry] }),
            }
        }
    }
    layers
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
    let (noisy, reason) = match color {
        Some(name) => (named(&layers, name)?, "as asked for"),
        None => find_color(&layers)?,
    };
    let channels = noisy.rgb().or_else(|| noisy.xyz()).ok_or_else(|| not_three(noisy))?;
    let color = noisy.pick(channels, reason);
    let target = combined_beside(&layers, noisy).unwrap_or_else(|| color.clone());
    let aux = |wish: &Wish, table| match wish {
        Wish::Without => Ok(None),
        Wish::Auto => Ok(find_aux(&layers, table, noisy)),
        Wish::Named(name) => {
            let layer = named(&layers, name)?;
            let channels = layer.triple().ok_or_else(|| not_three(layer))?;
            Ok(Some(layer.pick(channels, "as asked for")))
        }
    };
    let (albedo, normal) = (aux(albedo, conventions::ALBEDO)?, aux(normal, conventions::NORMAL)?);
    Ok(Choice { color, target, albedo, normal })
}

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
    let layer = by_name.or(plain).ok_or_else(|| no_color(&layers, usable.len()))?;
    let channels = layer.triple().ok_or_else(|| not_three(layer))?;
    Ok(layer.pick(channels, "from a file of its own"))
}

/// The layer called `name`: exactly, else in any case, else the only one whose last word it is.
///
/// # Errors
/// If there is none; the text lists those there are.
pub fn named<'a>(layers: &'a [Layer], name: &str) -> Result<&'a Layer, Problem> {
    let same = |l: &&Layer| l.name == name || (l.name.is_empty() && name == PLAIN);
    let alike = |l: &&Layer| l.shown().eq_ignore_ascii_case(name);
    let ends = |l: &&Layer| l.pass_name().1.eq_ignore_ascii_case(name);
    let only_end = || layers.iter().find(ends).filter(|_| layers.iter().filter(ends).count() == 1);
    let found = layers.iter().find(same).or_else(|| layers.iter().find(alike));
    found.or_else(only_end).ok_or_else(|| {
        Problem::Layers(format!("has no layer `{name}`; its layers are {}", list(layers)))
    })
}

impl Choice {
    /// One line for a person: what is read, why, and where the result goes.
    #[must_use]
    pub fn explain(&self) -> String {
        let say = |what: &str, pick: &Option<Pick>| match pick {
            Some(pick) => format!("{what} from `{}` ({})", pick.layer, pick.reason),
            None => format!("no {what}"),
        };
        format!(
            "colour from `{}` ({}), written to `{}`; {}; {}",
            self.color.layer,
            self.color.reason,
            self.target.layer,
            say("albedo", &self.albedo),
            say("normal", &self.normal)
        )
    }
}

/// What messages and the command line call the plain channels of a file with a single part.
const PLAIN: &str = "RGB";

impl Layer {
    /// The name as messages show it.
    #[must_use]
    pub fn shown(&self) -> &str {
        if self.name.is_empty() { PLAIN } else { &self.name }
    }

    /// Red, green and blue, if the layer has them.
    #[must_use]
    pub fn rgb(&self) -> Option<[usize; 3]> {
        self.find(["r", "g", "b"]).or_else(|| self.find(["red", "green", "blue"]))
    }

    /// The components x, y and z, if the layer has them.
    #[must_use]
    pub fn xyz(&self) -> Option<[usize; 3]> {
        self.find(["x", "y", "z"])
    }

    fn triple(&self) -> Option<[usize; 3]> {
        self.xyz().or_else(|| self.rgb())
    }

    fn find(&self, letters: [&str; 3]) -> Option<[usize; 3]> {
        let index = |letter: &str| {
            self.channels.iter().find(|(l, _)| l.eq_ignore_ascii_case(letter)).map(|(_, i)| *i)
        };
        Some([index(letters[0])?, index(letters[1])?, index(letters[2])?])
    }

    /// What stands before the last dot of the layer's name, and what stands after it.
    fn pass_name(&self) -> (&str, &str) {
        self.name.rsplit_once('.').unwrap_or(("", &self.name))
    }

    fn is(&self, convention: &Convention) -> bool {
        conventions::simple(self.pass_name().1) == convention.pass
            && (!convention.words || self.channels.iter().any(|(l, _)| l == "red"))
    }

    fn is_known_data(&self) -> bool {
        let known = conventions::ALBEDO.iter().chain(conventions::NORMAL);
        known.into_iter().any(|c| self.is(c)) || conventions::is_data(self.pass_name().1)
    }

    fn pick(&self, channels: [usize; 3], reason: &'static str) -> Pick {
        Pick { layer: self.shown().to_string(), part: self.part, channels, reason }
    }
}

/// Splits at the last dot; old pbrt files have `Nsx`, `Nsy`, `Nsz` without one.
fn split<'a>(full: &'a str, plain: &'a str) -> (&'a str, &'a str) {
    match full.rsplit_once('.') {
        Some(parts) => parts,
        None if ["Nsx", "Nsy", "Nsz", "Nx", "Ny", "Nz"].contains(&full) => {
            full.split_at(full.len() - 1)
        }
        None => (plain, full),
    }
}

fn find_color(layers: &[Layer]) -> Result<(&Layer, &'static str), Problem> {
    let has_rgb = |l: &&Layer| l.rgb().is_some();
    for convention in conventions::COLOR {
        if let Some(layer) = layers.iter().filter(has_rgb).find(|l| l.is(convention)) {
            return Ok((layer, convention.whose));
        }
    }
    let rest: Vec<_> = layers.iter().filter(has_rgb).filter(|l| !l.is_known_data()).collect();
    let has_alpha = |l: &&&Layer| l.find(["r", "g", "a"]).is_some();
    let with_alpha: Vec<_> = rest.iter().filter(has_alpha).collect();
    match (rest.as_slice(), with_alpha.as_slice()) {
        ([only], _) => Ok((only, "the only layer that can be the colour")),
        (_, [only]) => Ok((only, "the only layer with R, G, B and alpha")),
        _ => Err(no_color(layers, rest.len())),
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
        layer.triple().map(|channels| layer.pick(channels, convention.whose))
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
    combined.rgb().map(|channels| combined.pick(channels, "Blender's combined pass"))
}

fn not_three(layer: &Layer) -> Problem {
    let letters: Vec<_> = layer.channels.iter().map(|(l, _)| l.as_str()).collect();
    Problem::Layers(format!(
        "layer `{}` has the channels {} and not R, G, B or X, Y, Z",
        layer.shown(),
        letters.join(", ")
    ))
}

/// The names of all layers, for a message.
fn list(layers: &[Layer]) -> String {
    let names: Vec<_> = layers.iter().map(|l| format!("`{}`", l.shown())).collect();
    names.join(", ")
}

#[cfg(test)]
#[path = "layers_test.rs"]
mod tests;
