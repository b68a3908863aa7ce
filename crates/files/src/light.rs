//! Further light layers, such as light groups, denoised with the color's weights so that they still
//! add up to it.

use std::collections::{BTreeMap, BTreeSet};

use glob::{MatchOptions, Pattern};

use super::Problem;
use super::conventions;
use super::escape::escaped;
use super::layers::{Layer, Place, list, listed};
use super::pick::{ASKED_FOR, Pick};

/// Which further layers to denoise with the color's weights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LayersWish {
    /// Layers beside the color that by renderers' conventions add up to it.
    Auto,
    /// Layers that match a pattern with `*`, `?` or `[…]`, by full name or last word.
    Matching(Vec<String>),
}

impl LayersWish {
    /// Parses `auto` or patterns separated by commas.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        match text.trim() {
            "auto" => Self::Auto,
            list => Self::Matching(list.split(',').map(|item| item.trim().to_string()).collect()),
        }
    }

    /// The first layer that the caller named.
    pub(super) fn first(&self) -> Option<&str> {
        match self {
            Self::Auto => None,
            Self::Matching(patterns) => patterns.first().map(String::as_str),
        }
    }
}

/// Which patterns have matched a layer in any view.
pub(super) struct Matched(Vec<(String, bool)>);

impl Matched {
    pub(super) fn of(wish: Option<&LayersWish>) -> Self {
        match wish {
            Some(LayersWish::Matching(patterns)) => {
                Self(patterns.iter().map(|pattern| (pattern.clone(), false)).collect())
            }
            _ => Self(Vec::new()),
        }
    }

    /// Refuses a pattern that has matched nothing.
    pub(super) fn check(&self, layers: &[Layer]) -> Result<(), Problem> {
        match self.0.iter().find(|(_, matched)| !matched) {
            None => Ok(()),
            Some((pattern, _)) => Err(Problem::Layers(format!(
                "has no further layer `{}`; its layers are {}",
                escaped(pattern),
                list(layers)
            ))),
        }
    }
}

/// The further layers of one view.
#[derive(Debug, Default)]
pub(super) struct Light {
    pub(super) picks: Vec<Pick>,
    /// What a user should know about other layers, one sentence each.
    pub(super) left_out: Vec<String>,
}

/// The layers that can be denoised along with the color, by the names that find them in every view.
pub(super) fn possible<'a>(others: impl Iterator<Item = &'a Layer>) -> Vec<String> {
    let name = |layer: &Layer| Some(Pick::new(layer, usable(layer).ok()?, ASKED_FOR).pass);
    others.filter_map(name).collect()
}

/// Chooses among the layers of a view other than the color and its target.
pub(super) fn choose<'a>(
    others: impl Iterator<Item = &'a Layer>,
    color: &Layer,
    wish: Option<&LayersWish>,
    matched: &mut Matched,
) -> Result<Light, Problem> {
    match wish {
        None => Ok(Light::default()),
        Some(LayersWish::Auto) => {
            let (picks, _) = known(others, color);
            let none = "no further layer is known to add up to the color";
            let left_out = picks.is_empty().then(|| none.to_string()).into_iter().collect();
            Ok(Light { picks, left_out })
        }
        Some(LayersWish::Matching(_)) => matching(&others.collect::<Vec<_>>(), matched),
    }
}

/// The layers that by renderers' conventions add up to the color, and those beside the color that
/// hold something else, with what that is.
pub(super) fn known<'a>(
    others: impl Iterator<Item = &'a Layer>,
    color: &Layer,
) -> (Vec<Pick>, Vec<(String, &'static str)>) {
    let (mut picks, mut data) = (Vec::new(), Vec::new());
    let home = color.pass_name().0;
    for layer in others.filter(|l| [home, &color.base].contains(&l.pass_name().0)) {
        match (layer.rgb(), layer.data(), conventions::light(layer.pass_name().1)) {
            (_, Some(what), _) => data.push((layer.shown().to_string(), what)),
            (Some(channels), None, Some(whose)) => picks.push(Pick::new(layer, channels, whose)),
            _ => {}
        }
    }
    (picks, data)
}

/// The layers that match any pattern, in the file's order.
fn matching(others: &[&Layer], matched: &mut Matched) -> Result<Light, Problem> {
    let (mut chosen, mut left_out) = (BTreeMap::new(), BTreeSet::new());
    for (pattern, has_matched) in &mut matched.0 {
        let (found, is_exact) = find(others, pattern)?;
        *has_matched |= !found.is_empty();
        for i in found {
            match usable(others[i]) {
                Ok(channels) => {
                    let reason = if is_exact { ASKED_FOR } else { "matches a pattern" };
                    chosen.insert(i, Pick::new(others[i], channels, reason));
                }
                Err(what) if is_exact => return Err(refused(others[i], &what)),
                Err(_) => {
                    left_out.insert(i);
                }
            }
        }
    }
    let names = listed(left_out.iter().map(|&i| others[i].shown()));
    let said = format!("layers not denoised, because they hold no light that adds up: {names}");
    let left_out = (!left_out.is_empty()).then_some(said).into_iter().collect();
    Ok(Light { picks: chosen.into_values().collect(), left_out })
}

/// The layers that a pattern names, and whether it is the name of one.
fn find(others: &[&Layer], pattern: &str) -> Result<(Vec<usize>, bool), Problem> {
    let all = |is: &dyn Fn(&Layer) -> bool| -> Vec<usize> {
        (0..others.len()).filter(|&i| is(others[i])).collect()
    };
    let exact = all(&|l| l.shown() == pattern || l.base == pattern);
    if !exact.is_empty() || !pattern.contains(['*', '?', '[']) {
        let lower = pattern.to_lowercase();
        let word = |l: &Layer| l.pass_name().1.to_lowercase() == lower;
        let alike = |l: &Layer| l.shown().to_lowercase() == lower || word(l);
        return Ok((if exact.is_empty() { all(&alike) } else { exact }, true));
    }
    let glob = Pattern::new(pattern).map_err(|error| {
        Problem::Layers(format!("`{}` is not a valid pattern: {}", escaped(pattern), error.msg))
    })?;
    let matching = |case_sensitive| {
        let options = MatchOptions { case_sensitive, ..MatchOptions::default() };
        let names = |l: &Layer| [l.shown().to_string(), l.base.clone(), l.pass_name().1.into()];
        all(&|l| names(l).iter().any(|name| glob.matches_with(name, options)))
    };
    let found = matching(true);
    Ok((if found.is_empty() { matching(false) } else { found }, false))
}

/// The channels of a light layer, or why it is not one.
fn usable(layer: &Layer) -> Result<[Place; 3], String> {
    match (layer.data(), layer.rgb()) {
        (Some(what), _) => Err(format!("holds {what}")),
        (None, None) => Err("has no R, G and B".into()),
        (None, Some(channels)) => Ok(channels),
    }
}

fn refused(layer: &Layer, what: &str) -> Problem {
    Problem::Layers(format!(
        "layer `{}` {what} and no light that adds up to the color, so --layers cannot denoise it",
        escaped(layer.shown())
    ))
}
