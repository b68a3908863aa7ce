//! The layers of an EXR file, from the names of its parts and channels alone.
//!
//! A channel's full name is split at its last dot into a layer and a letter; a channel without
//! a dot belongs to the layer named like its part, or in a file with a single part to the
//! plain layer.

use std::collections::HashMap;

use super::Problem;
use super::conventions::{self, Convention};
use super::escape::escaped;

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

/// All layers of a file, in the order in which it names them.
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

/// The layer called `name`: exactly, else in any case, else the only one whose last word it is.
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

    /// X, y and z, or else red, green and blue.
    pub(super) fn triple(&self) -> Option<[usize; 3]> {
        self.xyz().or_else(|| self.rgb())
    }

    /// The indices of three channels, their letters in any case.
    pub(super) fn find(&self, letters: [&str; 3]) -> Option<[usize; 3]> {
        let index = |letter: &str| {
            self.channels.iter().find(|(l, _)| l.eq_ignore_ascii_case(letter)).map(|(_, i)| *i)
        };
        Some([index(letters[0])?, index(letters[1])?, index(letters[2])?])
    }

    /// What stands before the last dot of the layer's name, and what stands after it.
    pub(super) fn pass_name(&self) -> (&str, &str) {
        self.name.rsplit_once('.').unwrap_or(("", &self.name))
    }

    /// Whether its name is that of a convention.
    pub(super) fn is(&self, convention: &Convention) -> bool {
        conventions::simple(self.pass_name().1) == convention.pass
            && (!convention.words || self.channels.iter().any(|(l, _)| l == "red"))
    }

    /// Whether it is known to be something else than color.
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

/// A layer that was to be color and cannot be.
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

/// The names of layers, for a message.
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

    /// Grouping by comparing every two layers would make this test run for minutes.
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
