//! The layers of an EXR file, from the names of its parts and channels alone.
//!
//! A channel's full name is split at its last dot into a layer and a letter; a channel without
//! a dot belongs to the layer named like its part, or in a file with a single part to the
//! plain layer. Single channels of several parts, such as `rgba.R`, `rgba.G` and `rgba.B`, make one
//! layer.

use std::collections::{HashMap, HashSet};

use super::Problem;
use super::conventions::{self, Convention};
use super::escape::escaped;
use super::views::Views;

/// The names of one part of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// The part's `name` attribute.
    pub name: Option<String>,
    /// The full names of its channels, in the file's order.
    pub channels: Vec<String>,
    /// The part's `view` attribute.
    pub view: Option<String>,
    /// The part's `multiView` attribute: the views of its channels, the default one first.
    pub views: Vec<String>,
}

/// Where a channel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// Index of the part.
    pub part: usize,
    /// Index of the channel within the part.
    pub channel: usize,
}

/// Channels that share everything before the last dot of their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The shared name; empty for the plain channels of a file with a single part.
    pub name: String,
    /// The name without the view.
    pub base: String,
    /// The view that the layer belongs to; `None` if the file has only one.
    pub view: Option<String>,
    /// The word after the last dot of each channel, and where the channel is.
    pub channels: Vec<(String, Place)>,
    /// The name as messages show it, which no other layer has.
    shown: String,
}

/// All layers of a file, in the file's order.
#[must_use]
pub fn layers(parts: &[Part]) -> Vec<Layer> {
    let all = parts.iter().enumerate().flat_map(|(i, part)| {
        let plain = if parts.len() > 1 { part.name.as_deref().unwrap_or("") } else { "" };
        of_part(i, part, plain)
    });
    let mut layers = merged(parts, all);
    Views::of(parts, &layers).assign(parts, &mut layers);
    show(parts, &mut layers);
    layers
}

/// The layers of one part. `plain` is the name of the layer for channels without one.
fn of_part(part: usize, names: &Part, plain: &str) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut known = HashMap::new();
    let all: HashSet<&str> = names.channels.iter().map(String::as_str).collect();
    for (channel, full) in names.channels.iter().enumerate() {
        let (name, letter) = split(full, plain, &all);
        let index = *known.entry(name).or_insert(layers.len());
        if index == layers.len() {
            layers.push(Layer::new(name));
        }
        layers[index].channels.push((letter.to_string(), Place { part, channel }));
    }
    if let ([only], [channel]) = (layers.as_mut_slice(), names.channels.as_slice()) {
        only.leave_out(channel);
    }
    layers
}

/// Joins layers of one name and view that have a single channel each.
fn merged(parts: &[Part], all: impl Iterator<Item = Layer>) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut single: HashMap<(Option<&str>, String), usize> = HashMap::new();
    for layer in all {
        let [(letter, place)] = layer.channels.as_slice() else {
            layers.push(layer);
            continue;
        };
        let view = parts[place.part].view.as_deref();
        let index = *single.entry((view, layer.name.clone())).or_insert(layers.len());
        match layers.get_mut(index) {
            None => layers.push(layer),
            // There are no more than a few letters, or else the names differ.
            Some(first) if first.channels.len() < 5 && !first.has(letter) => {
                first.channels.push((letter.clone(), *place));
            }
            Some(_) => layers.push(layer),
        }
    }
    layers
}

/// Gives every layer the name that messages show: its own, or with that of its part if others have
/// the same.
fn show(parts: &[Part], layers: &mut [Layer]) {
    let mut count: HashMap<String, usize> = HashMap::new();
    for layer in layers.iter_mut() {
        layer.shown = layer.own_name();
        *count.entry(layer.shown.clone()).or_default() += 1;
    }
    for layer in layers.iter_mut().filter(|layer| count[&layer.shown] > 1) {
        let part = layer.part();
        let named = parts[part].name.clone().unwrap_or_else(|| part.to_string());
        layer.shown = format!("{named}.{}", layer.shown);
    }
}

/// The layers called `name`: the one with this name, or else those that have it in each view, or else
/// the only one with that last word.
///
/// # Errors
/// If there is none; the message lists the layers.
pub fn named<'a>(layers: &'a [Layer], name: &str) -> Result<Vec<&'a Layer>, Problem> {
    let lower = name.to_lowercase();
    let one = |is: &dyn Fn(&&Layer) -> bool| layers.iter().find(is).map(|layer| vec![layer]);
    one(&|l| l.shown == name)
        .or_else(|| one(&|l| l.shown.to_lowercase() == lower))
        .or_else(|| in_views(layers, &lower))
        .or_else(|| only(layers, |l| l.pass_name().1.to_lowercase() == lower))
        .ok_or_else(|| {
            let listed = list(layers);
            Problem::Layers(format!("has no layer `{}`; its layers are {listed}", escaped(name)))
        })
}

/// The layers of this name, in lower case, without the view.
fn in_views<'a>(layers: &'a [Layer], name: &str) -> Option<Vec<&'a Layer>> {
    let alike = |l: &&Layer| l.view.is_some() && l.base.to_lowercase() == name;
    Some(layers.iter().filter(alike).collect()).filter(|found: &Vec<_>| !found.is_empty())
}

fn only(layers: &[Layer], is: impl Fn(&&Layer) -> bool) -> Option<Vec<&Layer>> {
    let mut found = layers.iter().filter(is);
    let first = found.next()?;
    found.next().is_none().then(|| vec![first])
}

/// The channel of this full name, with its layer.
pub(super) fn channel<'a>(
    parts: &[Part],
    layers: &'a [Layer],
    name: &str,
) -> Option<(&'a Layer, Place)> {
    let place = parts.iter().enumerate().find_map(|(part, names)| {
        let channel = names.channels.iter().position(|full| full == name)?;
        Some(Place { part, channel })
    })?;
    let holds = |l: &&Layer| l.channels.iter().any(|(_, p)| *p == place);
    layers.iter().find(holds).map(|layer| (layer, place))
}

/// The name that stands for the plain channels of a file with a single part.
const PLAIN: &str = "RGB";

impl Layer {
    fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            base: name.into(),
            view: None,
            channels: Vec::new(),
            shown: String::new(),
        }
    }

    /// The name as messages show it.
    #[must_use]
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// Plain channels without color are named themselves.
    fn own_name(&self) -> String {
        if !self.name.is_empty() {
            return self.name.clone();
        }
        match self.channels.as_slice() {
            [(letter, _)] => letter.clone(),
            _ if self.rgb().is_none() && self.xyz().is_some() => "XYZ".into(),
            _ => PLAIN.into(),
        }
    }

    /// Index of the part that holds the layer, or its first channel.
    #[must_use]
    pub fn part(&self) -> usize {
        self.channels[0].1.part
    }

    /// Red, green and blue, if the layer has them.
    #[must_use]
    pub fn rgb(&self) -> Option<[Place; 3]> {
        self.find(["r", "g", "b"]).or_else(|| self.find(["red", "green", "blue"]))
    }

    /// The components x, y and z, if the layer has them.
    #[must_use]
    pub fn xyz(&self) -> Option<[Place; 3]> {
        self.find(["x", "y", "z"])
    }

    /// Alpha, if the layer has it.
    #[must_use]
    pub fn alpha(&self) -> Option<Place> {
        let is_alpha = |letter: &str| matches!(letter.to_lowercase().as_str(), "a" | "alpha");
        self.channels.iter().find(|(letter, _)| is_alpha(letter)).map(|(_, place)| *place)
    }

    /// X, y and z, or else red, green and blue.
    pub(super) fn triple(&self) -> Option<[Place; 3]> {
        self.xyz().or_else(|| self.rgb())
    }

    /// The only channel besides alpha.
    pub(super) fn single(&self) -> Option<Place> {
        let alpha = self.alpha();
        match self.channels.as_slice() {
            [(_, only)] => Some(*only),
            [(_, a), (_, b)] if alpha == Some(*a) => Some(*b),
            [(_, a), (_, b)] if alpha == Some(*b) => Some(*a),
            _ => None,
        }
    }

    /// The channels with these lower-case letters: in upper case, else in lower case, else in any.
    pub(super) fn find(&self, letters: [&str; 3]) -> Option<[Place; 3]> {
        let find = |is: &dyn Fn(&str, &str) -> bool| {
            let place = |letter: &str| {
                self.channels.iter().find(|(l, _)| is(l, letter)).map(|(_, place)| *place)
            };
            Some([place(letters[0])?, place(letters[1])?, place(letters[2])?])
        };
        find(&|l, letter| l == letter.to_uppercase())
            .or_else(|| find(&|l, letter| l == letter))
            .or_else(|| find(&|l, letter| l.eq_ignore_ascii_case(letter)))
    }

    fn has(&self, letter: &str) -> bool {
        self.channels.iter().any(|(l, _)| l == letter)
    }

    /// The name without the view, before and after its last dot.
    pub(super) fn pass_name(&self) -> (&str, &str) {
        self.base.rsplit_once('.').unwrap_or(("", &self.base))
    }

    /// Whether its name follows a convention.
    pub(super) fn is(&self, convention: &Convention) -> bool {
        conventions::simple(self.pass_name().1) == convention.pass
            && (!convention.words || self.has("red"))
    }

    /// What it holds other than light, if its name tells.
    pub(super) fn data(&self) -> Option<&'static str> {
        let is = |table: &[Convention]| table.iter().any(|c| self.is(c));
        match () {
            () if is(conventions::ALBEDO) => Some("albedo"),
            () if is(conventions::NORMAL) => Some("normals"),
            () => conventions::data(self.pass_name().1),
        }
    }

    /// Turns the name `rgba.R` of a part with the one channel `R` into `rgba`, and `R` into none.
    fn leave_out(&mut self, channel: &str) {
        let is_color = ["R", "G", "B", "A"].contains(&channel);
        match self.name.strip_suffix(channel) {
            Some("") if is_color => self.name.clear(),
            Some(rest) if rest.ends_with(['.', '_']) => {
                self.name = rest.trim_end_matches(['.', '_']).to_string();
            }
            _ => {}
        }
        self.base.clone_from(&self.name);
    }
}

/// Splits at the last dot. Without one, `normal_x` or `beauty:R` next to its two siblings is a layer's,
/// and so are `Nsx`, `Nsy`, `Nsz` of old pbrt files. A name that ends in a dot has no layer.
fn split<'a>(full: &'a str, plain: &'a str, all: &HashSet<&str>) -> (&'a str, &'a str) {
    match full.rsplit_once('.') {
        Some((name, "")) => (plain, name),
        Some(parts) => parts,
        None if ["Nsx", "Nsy", "Nsz", "Nx", "Ny", "Nz"].contains(&full) => {
            full.split_at(full.len() - 1)
        }
        None => split_siblings(full, all).unwrap_or((plain, full)),
    }
}

fn split_siblings<'a>(full: &'a str, all: &HashSet<&str>) -> Option<(&'a str, &'a str)> {
    let (name, letter) = full.rsplit_once(['_', ':'])?;
    let stem = &full[..=name.len()];
    let has = |letters: &&[&str; 3]| {
        letters.iter().all(|letter| all.contains(format!("{stem}{letter}").as_str()))
    };
    let sets = [["R", "G", "B"], ["r", "g", "b"], ["X", "Y", "Z"], ["x", "y", "z"]];
    let known = sets.iter().any(|set| set.contains(&letter)) || ["A", "a"].contains(&letter);
    (known && !name.is_empty() && sets.iter().any(|set| has(&set))).then_some((name, letter))
}

/// The problem with a layer that lacks three channels.
pub(super) fn not_three(layer: &Layer) -> Problem {
    let letters: Vec<_> = layer.channels.iter().map(|(l, _)| escaped(l)).collect();
    Problem::Layers(format!(
        "layer `{}` has the channels {} and not R, G, B or X, Y, Z",
        escaped(layer.shown()),
        letters.join(", ")
    ))
}

/// Most names in one message.
const MOST_LISTED: usize = 20;

/// The names of layers, as messages list them. Plain channels without color are listed one by one.
pub(super) fn list<'a>(layers: impl IntoIterator<Item = &'a Layer>) -> String {
    listed(layers.into_iter().flat_map(Layer::names))
}

/// Names in backquotes, the first ones of many.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut rest = names.into_iter();
    let names: Vec<_> =
        rest.by_ref().take(MOST_LISTED).map(|name| format!("`{}`", escaped(name))).collect();
    let more = rest.count();
    let end = if more > 0 { format!(" and {more} more") } else { String::new() };
    names.join(", ") + &end
}

impl Layer {
    /// The names that a user can give for it or its channels.
    fn names(&self) -> Vec<&str> {
        if self.name.is_empty() && self.triple().is_none() {
            return self.channels.iter().map(|(letter, _)| letter.as_str()).collect();
        }
        vec![self.shown()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quadratic grouping would take minutes here.
    #[test]
    fn a_great_many_layers_are_told_apart_and_few_are_listed() {
        let channel = |i: usize| format!("light{}.{}", i % 50_000, ["R", "G", "B"][i / 50_000]);
        let channels = (0..150_000).map(channel).collect();
        let part = Part { channels, ..Part::default() };
        let layers = layers(&[part]);
        assert_eq!(
            (layers.len(), layers[7].rgb()),
            (50_000, Some([7, 50_007, 100_007].map(|channel| Place { part: 0, channel })))
        );
        let error = named(&layers, "beauty").unwrap_err().to_string();
        assert!(error.ends_with("`light18`, `light19` and 49980 more"), "{error}");
    }
}
