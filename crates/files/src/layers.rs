//! Groups an EXR file's channels into layers, from the names of its parts and channels alone.
//!
//! A channel's full name is split at its last dot into a layer and a letter; a channel without a
//! dot belongs to the layer named like its part, or in a file with a single part to the plain
//! layer. Single channels of several parts, such as `rgba.R`, `rgba.G` and `rgba.B`, make one
//! layer.

use std::collections::{HashMap, HashSet};

use super::Problem;
use super::escape::escaped;
use super::views::Views;

pub(super) use super::layer::PLAIN;
pub use super::layer::{Layer, Part, Place};

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

/// The layers of one part. `plain` names the layer of channels without one.
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

/// Merges layers of the same name and view that have a single channel each.
fn merged(parts: &[Part], all: impl Iterator<Item = Layer>) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut single: HashMap<(Option<&str>, String), usize> = HashMap::new();
    for layer in all {
        if let [(letter, place)] = layer.channels.as_slice() {
            let view = parts[place.part].view.as_deref();
            let index = *single.entry((view, layer.name.clone())).or_insert(layers.len());
            // There are no more than a few letters, or else the names differ.
            let joins = |first: &&mut Layer| first.channels.len() < 5 && !first.has(letter);
            if let Some(first) = layers.get_mut(index).filter(joins) {
                first.channels.push((letter.clone(), *place));
                continue;
            }
        }
        layers.push(layer);
    }
    layers
}

/// Sets the name that messages show: the layer's own, with its part's name added if others have the
/// same.
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

/// The layers called `name`: the layer itself, or else those of that name in each view, or else the
/// only one with that last word.
///
/// # Errors
/// If there is none; the message lists the layers.
pub fn named<'a>(layers: &'a [Layer], name: &str) -> Result<Vec<&'a Layer>, Problem> {
    let lower = name.to_lowercase();
    let one = |is: &dyn Fn(&&Layer) -> bool| layers.iter().find(is).map(|layer| vec![layer]);
    one(&|l| l.shown == name)
        .or_else(|| one(&|l| l.shown.to_lowercase() == lower))
        .or_else(|| in_views(layers, &lower))
        .or_else(|| only(layers, |l| !lower.is_empty() && l.pass_name().1.to_lowercase() == lower))
        .ok_or_else(|| {
            let listed = list(layers);
            Problem::Layers(format!("has no layer `{}`; its layers are {listed}", escaped(name)))
        })
}

/// The layers that have this lower-case name apart from their view.
fn in_views<'a>(layers: &'a [Layer], name: &str) -> Option<Vec<&'a Layer>> {
    let alike = |l: &&Layer| l.view.is_some() && l.base.to_lowercase() == name;
    Some(layers.iter().filter(alike).collect()).filter(|found: &Vec<_>| !found.is_empty())
}

fn only(layers: &[Layer], is: impl Fn(&&Layer) -> bool) -> Option<Vec<&Layer>> {
    let mut found = layers.iter().filter(is);
    let first = found.next()?;
    found.next().is_none().then(|| vec![first])
}

/// Finds a channel by its full name, with its layer.
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

/// Splits a channel's name at its last dot. Without one, `normal_x` or `beauty:R` next to its two
/// siblings has a layer too, as have `Nsx`, `Nsy`, `Nsz` of old pbrt files. A name that ends in a
/// dot has no layer.
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

/// The error for a layer that lacks three channels.
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

/// Lists the names of layers for messages. Plain channels without color are listed one by one.
pub(super) fn list<'a>(layers: impl IntoIterator<Item = &'a Layer>) -> String {
    listed(layers.into_iter().flat_map(Layer::names))
}

/// Lists names in backquotes, only the first of many.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut rest = names.into_iter();
    let names: Vec<_> =
        rest.by_ref().take(MOST_LISTED).map(|name| format!("`{}`", escaped(name))).collect();
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
