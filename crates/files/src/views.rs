//! Assigns each layer of a stereo or multi-view file to its view.
//!
//! A part's attribute `view` names its view. In a part with the attribute `multiView`, a layer's
//! first or last word is its view (`right.albedo`, Blender's `ViewLayer.Combined.right`), and
//! layers that name none belong to the first one. Without either, `left` and `right`, or only
//! `main`, are views if every color layer has one of them as its first or last word.

use std::collections::{HashMap, HashSet};

use super::Problem;
use super::layer::{Layer, Part};

/// The views of a file.
pub(super) struct Views {
    /// The names of all views, by their lower case.
    names: HashMap<String, String>,
    /// The view of layers that name none.
    default: Option<String>,
}

impl Views {
    pub(super) fn of(parts: &[Part], layers: &[Layer]) -> Self {
        let declared = parts.iter().flat_map(|part| part.view.iter().chain(&part.views));
        let names: HashMap<_, _> =
            declared.map(|view| (view.to_lowercase(), view.clone())).collect();
        let default = parts.iter().find_map(|part| part.views.first().cloned());
        if names.is_empty() { Self::by_words(layers) } else { Self { names, default } }
    }

    /// The views of a file that declares none.
    fn by_words(layers: &[Layer]) -> Self {
        let pairs = |words: &[&str]| words.iter().map(|w| ((*w).into(), (*w).into())).collect();
        for words in [&["left", "right"][..], &["main"]] {
            let views = Self { names: pairs(words), default: None };
            let color = layers.iter().filter(|layer| layer.rgb().is_some());
            let found: Vec<_> = color.map(|layer| views.split(&layer.name)).collect();
            let named: HashSet<_> = found.iter().flatten().map(|(view, _)| *view).collect();
            if named.len() == words.len() && found.iter().all(Option::is_some) {
                return views;
            }
        }
        Self { names: HashMap::new(), default: None }
    }

    /// Assigns every layer its view, or none in a file with one view.
    pub(super) fn assign(&self, parts: &[Part], layers: &mut [Layer]) {
        for layer in layers.iter_mut() {
            let (view, base) = match (&parts[layer.part()].view, self.split(&layer.name)) {
                (Some(view), split) => {
                    let own = split.filter(|(named, _)| *named == view);
                    (Some(view.clone()), own.map(|(_, base)| base))
                }
                (None, Some((view, base))) => (Some(view.to_string()), Some(base)),
                (None, None) => (self.default.clone(), None),
            };
            layer.view = view;
            layer.base = base.unwrap_or_else(|| layer.name.clone());
        }
        let views: HashSet<_> = layers.iter().filter_map(|layer| layer.view.as_deref()).collect();
        if views.len() == 1 {
            for layer in layers {
                layer.view = None;
            }
        }
    }

    /// Splits a layer's name into its view, which is the last or first word, and the rest.
    fn split<'a>(&'a self, name: &str) -> Option<(&'a str, String)> {
        let view = |word: &str| self.names.get(&word.to_lowercase()).map(String::as_str);
        let end = name.rfind(['.', '_']).map_or(0, |dot| dot + 1);
        if let Some(view) = view(&name[end..]) {
            return Some((view, name[..end].trim_end_matches(['.', '_']).into()));
        }
        let (first, rest) = name.split_once('.')?;
        view(first).map(|view| (view, rest.into()))
    }
}

/// The layers of one view.
pub(super) struct View<'a> {
    pub(super) name: Option<&'a str>,
    pub(super) layers: Vec<&'a Layer>,
}

/// Groups layers by view, in the file's order, but the default view first.
pub(super) fn by_view<'a>(
    layers: &'a [Layer],
    default: Option<&String>,
) -> Result<Vec<View<'a>>, Problem> {
    let mut views: Vec<View<'_>> = Vec::new();
    let mut known = HashMap::new();
    for layer in layers {
        let name = layer.view.as_deref();
        let index = *known.entry(name).or_insert(views.len());
        if index == views.len() {
            views.push(View { name, layers: Vec::new() });
        }
        views[index].layers.push(layer);
    }
    if views.len() > MOST_VIEWS {
        let found = views.len();
        return Err(Problem::TooLarge(format!(
            "has {found} views, and at most {MOST_VIEWS} are accepted"
        )));
    }
    views.sort_by_key(|view| view.name != default.map(String::as_str));
    Ok(views)
}

/// Most views in a file; light-field cameras have some hundred.
const MOST_VIEWS: usize = 512;
