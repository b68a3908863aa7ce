//! Albedo and normals: which layers they are.
//!
//! They come from the color's own view, and there from the layers inside the color's own, then from
//! those beside it, then from those above, and never from another prefix: the albedo of another camera
//! or light would tear the picture apart.

use std::collections::HashMap;

use super::Problem;
use super::choice::Pick;
use super::conventions::{ALBEDO, Convention, NORMAL};
use super::escape::escaped;
use super::layers::{Layer, Part, layers, list, not_three};

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

    /// The place of a layer's convention in the table, the preferred first.
    fn rank(self, layer: &Layer) -> Option<usize> {
        self.table().iter().position(|convention| layer.is(convention))
    }
}

/// The albedo and the normals of one view, by their prefix.
pub(super) struct Features<'a> {
    by_prefix: [HashMap<&'a str, (usize, &'a Layer)>; 2],
}

impl<'a> Features<'a> {
    pub(super) fn of(layers: impl Iterator<Item = &'a Layer>) -> Self {
        let mut by_prefix = [HashMap::new(), HashMap::new()];
        for layer in layers.filter(|layer| layer.triple().is_some()) {
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

    /// The one nearest to the color.
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

    /// Why there is none, if the file has some elsewhere.
    pub(super) fn elsewhere(layers: &[Layer], color: &Layer, kind: Kind) -> Option<String> {
        let other = |l: &&Layer| *l != color && l.triple().is_some() && kind.rank(l).is_some();
        let other = layers.iter().find(other)?;
        let of = if other.view == color.view { "prefix" } else { "view" };
        Some(format!("`{}` belongs to another {of}", escaped(other.shown())))
    }
}

/// The prefix without its last word; `None` of the empty prefix.
fn above(prefix: &str) -> Option<&str> {
    match prefix {
        "" => None,
        _ => Some(prefix.rsplit_once('.').map_or("", |(rest, _)| rest)),
    }
}

/// Where the layers of a prefix are, seen from the color.
fn near(color: &Layer, prefix: &str) -> String {
    let place = match prefix {
        _ if prefix == color.pass_name().0 => ", beside the color",
        _ if prefix == color.base => ", inside the color's layer",
        _ => ", above the color",
    };
    let view = color.view.as_ref().map(|_| " and of its view").unwrap_or_default();
    // In a file without prefixes and views, all layers are side by side.
    if color.view.is_none() && !color.base.contains('.') && prefix.is_empty() {
        return String::new();
    }
    format!("{place}{view}")
}

/// The albedo or normal of a separate file: by its name, or else the plain or only layer.
///
/// # Errors
/// If no layer can be it.
pub fn choose_single(parts: &[Part], kind: Kind) -> Result<Pick, Problem> {
    let layers = layers(parts);
    let by_name = kind.table().iter().find_map(|c| layers.iter().find(|l| l.is(c)));
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
