//! Finds the albedo and normal layers.
//!
//! They come from the color's own view: from the layers inside the color's own, then from those
//! beside it, then from those above, and never from another prefix, since the albedo of another
//! camera or light would tear the picture apart.

use std::collections::HashMap;

use super::Problem;
use super::conventions::{ALBEDO, Convention, NORMAL};
use super::escape::escaped;
use super::layers::{Layer, Part, layers, list, not_three};
use super::pick::Pick;

/// What a layer or a separate file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Albedo.
    Albedo,
    /// Normals.
    Normal,
}

impl Kind {
    fn table(self) -> &'static [Convention] {
        match self {
            Self::Albedo => ALBEDO,
            Self::Normal => NORMAL,
        }
    }

    /// The rank of a layer's convention in the table, preferred first.
    fn rank(self, layer: &Layer) -> Option<usize> {
        layer.triple().and_then(|_| layer.convention(self.table()))
    }
}

/// A view's albedo and normal layers, by prefix.
pub(super) struct Features<'a> {
    by_prefix: [HashMap<&'a str, (usize, &'a Layer)>; 2],
}

impl<'a> Features<'a> {
    pub(super) fn of(layers: impl Iterator<Item = &'a Layer>) -> Self {
        let mut by_prefix = [HashMap::new(), HashMap::new()];
        for layer in layers {
            for (kind, found) in [Kind::Albedo, Kind::Normal].into_iter().zip(&mut by_prefix) {
                let Some(rank) = kind.rank(layer) else { continue };
                let best = found.entry(layer.pass_name().0).or_insert((rank, layer));
                if rank < best.0 {
                    *best = (rank, layer);
                }
            }
        }
        Self { by_prefix }
    }

    /// The layer of this kind nearest to the color.
    pub(super) fn near(&self, color: &Layer, kind: Kind) -> Option<Pick> {
        let found = &self.by_prefix[kind as usize];
        let mut prefix = Some(color.base.as_str());
        while let Some(name) = prefix {
            if let Some((rank, layer)) = found.get(name) {
                let reason = format!("{}{}", kind.table()[*rank].whose, near(color, name));
                return layer.triple().map(|channels| Pick::new(layer, channels, reason));
            }
            prefix = above(name);
        }
        None
    }
}

/// Up to two of the file's layers of this kind.
pub(super) fn some(layers: &[Layer], kind: Kind) -> Vec<&Layer> {
    layers.iter().filter(|layer| kind.rank(layer).is_some()).take(2).collect()
}

/// Why the color uses none of these layers; `None` if there is no other layer than the color.
pub(super) fn elsewhere(some: &[&Layer], color: &Layer) -> Option<String> {
    let other = some.iter().find(|layer| **layer != color)?;
    let of = if other.view == color.view { "prefix" } else { "view" };
    Some(format!("`{}` belongs to another {of}", escaped(other.shown())))
}

/// The prefix without its last word; `None` for the empty prefix.
fn above(prefix: &str) -> Option<&str> {
    match prefix {
        "" => None,
        _ => Some(prefix.rsplit_once('.').map_or("", |(rest, _)| rest)),
    }
}

/// Where a prefix is relative to the color, in words; empty in a file without prefixes and views.
fn near(color: &Layer, prefix: &str) -> &'static str {
    match prefix {
        _ if prefix == color.pass_name().0 && color.view.is_some() => ", of the same view",
        "" if !color.base.contains('.') => "",
        _ if prefix == color.pass_name().0 => ", beside the color",
        _ if prefix == color.base => ", inside the color's layer",
        _ => ", above the color",
    }
}

/// Chooses the albedo or normal of a separate file: by name, or else the plain or only layer.
///
/// # Errors
/// If no layer qualifies.
pub fn choose_single(parts: &[Part], kind: Kind) -> Result<Pick, Problem> {
    let layers = layers(parts);
    let known = layers.iter().filter_map(|l| Some((l.convention(kind.table())?, l)));
    let by_name = known.min_by_key(|(rank, _)| *rank).map(|(_, layer)| layer);
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
