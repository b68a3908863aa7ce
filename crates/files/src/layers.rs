//! The layers of an EXR file, from the names of its parts and channels alone.
//!
//! A channel's full name is split at its last dot into a layer and a letter; a channel without
//! a dot belongs to the layer named like its part, or in a file with a single part to the
//! plain layer.

use std::collections::HashMap;

use super::Problem;
use super::conventions::{self, Convention};
use super::escape::escaped;

/// The names of one part of a file.
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
    /// Index of its part.
    pub part: usize,
    /// The word after the last dot, and the channel's index in the part.
    pub channels: Vec<(String, usize)>,
}

/// All layers of a file, in the file's order.
#[must_use]
pub fn layers(parts: &[Part]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, names) in parts.iter().enumerate() {
        let plain = if parts.len() > 1 { names.name.as_deref().unwrap_or("") } else { "" };
        let mut known = HashMap::new();
        for (channel, full) in names.channels.iter().enumerate() {
            let (name, letter) = split(full, plain);
            let index = *known.entry(name).or_insert(layers.len());
            if index == layers.len() {
                layers.push(Layer { name: name.into(), part, channels: Vec::new() });
            }
            layers[index].channels.push((letter.to_string(), channel));
        }
    }
    layers
}

/// The layer called `name`: exactly, or else in any case, or else the only one with that last word.
///
/// # Errors
/// If there is none; the message lists the layers.
pub fn named<'a>(layers: &'a [Layer], name: &str) -> Result<&'a Layer, Problem> {
    let same = |l: &&Layer| l.name == name || (l.name.is_empty() && name == PLAIN);
    let alike = |l: &&Layer| l.shown().eq_ignore_ascii_case(name);
    let ends = |l: &&Layer| l.pass_name().1.eq_ignore_ascii_case(name);
    let only_end = || layers.iter().find(ends).filter(|_| layers.iter().filter(ends).count() == 1);
    let found = layers.iter().find(same).or_else(|| layers.iter().find(alike));
    found.or_else(only_end).ok_or_else(|| {
        Problem::Layers(format!(
            "has no layer `{}`; its layers are {}",
            escaped(name),
            list(layers)
        ))
    })
}

/// The name that stands for the plain channels of a file with a single part.
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

    /// X, y and z, or else red, green and blue.
    pub(super) fn triple(&self) -> Option<[usize; 3]> {
        self.xyz().or_else(|| self.rgb())
    }

    /// Indices of the channels with these letters, in any case.
    pub(super) fn find(&self, letters: [&str; 3]) -> Option<[usize; 3]> {
        let index = |letter: &str| {
            self.channels.iter().find(|(l, _)| l.eq_ignore_ascii_case(letter)).map(|(_, i)| *i)
        };
        Some([index(letters[0])?, index(letters[1])?, index(letters[2])?])
    }

    /// The layer's name before and after its last dot.
    pub(super) fn pass_name(&self) -> (&str, &str) {
        self.name.rsplit_once('.').unwrap_or(("", &self.name))
    }

    /// Whether its name follows a convention.
    pub(super) fn is(&self, convention: &Convention) -> bool {
        conventions::simple(self.pass_name().1) == convention.pass
            && (!convention.words || self.channels.iter().any(|(l, _)| l == "red"))
    }

    /// Whether it is known to hold something other than color.
    pub(super) fn is_known_data(&self) -> bool {
        let known = conventions::ALBEDO.iter().chain(conventions::NORMAL);
        known.into_iter().any(|c| self.is(c)) || conventions::is_data(self.pass_name().1)
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

/// The problem with a layer that lacks three channels.
pub(super) fn not_three(layer: &Layer) -> Problem {
    let letters: Vec<_> = layer.channels.iter().map(|(l, _)| escaped(l)).collect();
    Problem::Layers(format!(
        "layer `{}` has the channels {} and not R, G, B or X, Y, Z",
        layer.shown(),
        letters.join(", ")
    ))
}

/// Most names in one message.
const MOST_LISTED: usize = 20;

/// The names of layers, as messages list them.
pub(super) fn list<'a>(layers: impl IntoIterator<Item = &'a Layer>) -> String {
    let mut rest = layers.into_iter();
    let names: Vec<_> =
        rest.by_ref().take(MOST_LISTED).map(|l| format!("`{}`", escaped(l.shown()))).collect();
    let more = rest.count();
    let end = if more > 0 { format!(" and {more} more") } else { String::new() };
    names.join(", ") + &end
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quadratic grouping would take minutes here.
    #[test]
    fn a_great_many_layers_are_told_apart_and_few_are_listed() {
        let channel = |i: usize| format!("light{}.{}", i % 50_000, ["R", "G", "B"][i / 50_000]);
        let part = Part { name: None, channels: (0..150_000).map(channel).collect() };
        let layers = layers(&[part]);
        assert_eq!((layers.len(), layers[7].rgb()), (50_000, Some([7, 50_007, 100_007])));
        let error = named(&layers, "beauty").unwrap_err().to_string();
        assert!(error.ends_with("`light18`, `light19` and 49980 more"), "{error}");
    }
}
