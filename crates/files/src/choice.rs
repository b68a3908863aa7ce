//! Chooses the color, albedo and normal layers of an EXR file, from names alone, for each view.
//!
//! `Noisy Image` is read instead of the combined layer, and the result goes into the combined layer
//! of the same view layer, if there is one.

use std::collections::HashSet;

use super::Problem;
use super::conventions;
use super::escape::escaped;
use super::features::{self, Features, Kind};
use super::layers::{Layer, Part, Place, channel, layers, list, listed, named, not_three};
use super::light::{self, LayersWish, Matched};
use super::motion::{self, MotionPick, MotionWish};
use super::pick::{ASKED_FOR, Pick};
use super::views::{View, by_view};

/// How to choose a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Wish {
    /// By the names that renderers use.
    #[default]
    Auto,
    /// Not at all.
    Without,
    /// The layer of this name.
    Named(String),
}

/// How to choose all layers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wishes {
    /// The color; `None` for the color of every view, found by the names that renderers use.
    pub color: Option<String>,
    /// The albedo.
    pub albedo: Wish,
    /// The normal.
    pub normal: Wish,
    /// Further light layers; none by default.
    pub layers: Option<LayersWish>,
    /// The motion vectors.
    pub motion: MotionWish,
}

/// The layers to read and to write for one view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The view's name; `None` if the file has only one.
    pub view: Option<String>,
    /// The noisy color.
    pub color: Pick,
    /// Where the denoised color goes.
    pub target: Pick,
    /// The alpha to read, and the one to write.
    pub alpha: Option<(Place, Place)>,
    /// The albedo, if any.
    pub albedo: Option<Pick>,
    /// The normal, if any.
    pub normal: Option<Pick>,
    /// Why albedo and normal are missing, if the file has layers that look like them.
    pub missing: [Option<String>; 2],
    /// The further layers of light.
    pub layers: Vec<Pick>,
    /// The motion vectors.
    pub motion: Option<MotionPick>,
    /// Names, without the view, of all layers that can be denoised along with the color.
    pub possible_layers: Vec<String>,
    /// Other layers that could be the color.
    pub other_colors: Vec<String>,
    /// Why layers that were found are not used, one sentence each.
    pub left_out: Vec<String>,
}

/// Chooses the layers to read and to write, view by view.
///
/// # Errors
/// If a named layer is missing or has the wrong channels, or no layer can be the color.
pub fn choose(parts: &[Part], wishes: &Wishes) -> Result<Vec<Choice>, Problem> {
    let layers = layers(parts);
    let views = by_view(&layers, parts.iter().find_map(|part| part.views.first()))?;
    let (colors, left_out) = match &wishes.color {
        Some(name) => (named_colors(parts, &layers, &views, name)?, Vec::new()),
        None => found_colors(&views)?,
    };
    let mut matched = Matched::of(wishes.layers.as_ref());
    let some = [Kind::Albedo, Kind::Normal].map(|kind| features::some(&layers, kind));
    let context = Context { layers: &layers, wishes, some, only: colors.len() == 1 };
    let choices = colors.iter().map(|color| color.choice(&context, &mut matched));
    let mut choices = choices.collect::<Result<Vec<_>, _>>()?;
    matched.check(&layers)?;
    choices[0].left_out.extend(left_out);
    if wishes.color.is_some() {
        choices[0].other_colors.extend(colors_of_others(&views, &colors));
    }
    Ok(choices)
}

/// A color to denoise.
struct Color<'a> {
    view: &'a View<'a>,
    layer: &'a Layer,
    pick: Pick,
    /// Other layers named by the same convention.
    others: Vec<&'a Layer>,
}

/// What all views share.
struct Context<'a> {
    layers: &'a [Layer],
    wishes: &'a Wishes,
    /// Up to two albedo and two normal layers of the file.
    some: [Vec<&'a Layer>; 2],
    /// Whether only one view is denoised.
    only: bool,
}

impl Color<'_> {
    fn choice(&self, context: &Context<'_>, matched: &mut Matched) -> Result<Choice, Problem> {
        let target = combined_beside(&self.view.layers, self.layer);
        let written = target.as_ref().map_or(self.layer, |(layer, _)| layer);
        let others = || self.view.layers.iter().filter(|l| **l != self.layer && **l != written);
        let features = Features::of(others().copied());
        let wishes = context.wishes;
        let (albedo, no_albedo) = self.feature(context, &features, &wishes.albedo, Kind::Albedo)?;
        let (normal, no_normal) = self.feature(context, &features, &wishes.normal, Kind::Normal)?;
        let light = light::choose(others().copied(), self.layer, wishes.layers.as_ref(), matched)?;
        Ok(Choice {
            view: self.view.name.map(Into::into),
            color: self.pick.clone(),
            alpha: self.alpha(written),
            target: target.map_or_else(|| self.pick.clone(), |(_, pick)| pick),
            albedo,
            normal,
            missing: [no_albedo, no_normal],
            layers: light.picks,
            motion: motion::choose(others().copied(), self.layer, context.layers, &wishes.motion)?,
            possible_layers: light::possible(others().copied()),
            other_colors: self.others.iter().map(|l| l.shown().to_string()).collect(),
            left_out: light.left_out,
        })
    }

    /// Finds the albedo or the normal, or says why there is none.
    fn feature(
        &self,
        context: &Context<'_>,
        features: &Features<'_>,
        wish: &Wish,
        kind: Kind,
    ) -> Result<(Option<Pick>, Option<String>), Problem> {
        let named = match wish {
            Wish::Without => return Ok((None, None)),
            Wish::Auto => None,
            Wish::Named(name) => self.named_feature(context, name)?,
        };
        let pick = named.or_else(|| features.near(self.layer, kind));
        let why = || features::elsewhere(&context.some[kind as usize], self.layer);
        let missing = if pick.is_none() { why() } else { None };
        Ok((pick, missing))
    }

    /// Finds the alpha to read, in the color's layer, and the alpha to write, in the target. Either
    /// may instead be a layer `alpha` beside the color.
    fn alpha(&self, written: &Layer) -> Option<(Place, Place)> {
        let beside = || {
            let home = self.layer.pass_name().0;
            let is_alpha = |l: &&&Layer| {
                let (prefix, pass) = l.pass_name();
                prefix == home && pass.eq_ignore_ascii_case("alpha") && l.channels.len() == 1
            };
            self.view.layers.iter().find(is_alpha).and_then(|l| l.alpha())
        };
        let place = |layer: &Layer| layer.alpha().or_else(beside);
        let (read, write) = (place(self.layer)?, place(written)?);
        (!self.pick.channels.contains(&read)).then_some((read, write))
    }

    /// The layer of this name in the color's view; `None` if only another of several views has it.
    fn named_feature(&self, context: &Context<'_>, name: &str) -> Result<Option<Pick>, Problem> {
        let found = named(context.layers, name)?;
        let own = found.iter().find(|layer| layer.view.as_deref() == self.view.name);
        let any = || found.first().filter(|_| context.only);
        let Some(layer) = own.or_else(any) else { return Ok(None) };
        let channels = layer.triple().ok_or_else(|| not_three(layer))?;
        Ok(Some(Pick::new(layer, channels, ASKED_FOR)))
    }
}

/// The colors that `name` stands for: a layer, a layer in each view, a view or a channel.
fn named_colors<'a>(
    parts: &[Part],
    layers: &'a [Layer],
    views: &'a [View<'a>],
    name: &str,
) -> Result<Vec<Color<'a>>, Problem> {
    let view_of = |layer: &Layer| {
        let is_its = |view: &&View<'_>| view.name == layer.view.as_deref();
        views.iter().find(is_its).expect("every layer is in a view")
    };
    let color = |layer: &'a Layer, channels: [Place; 3]| {
        let reason = if channels == [channels[0]; 3] { AS_GRAY } else { ASKED_FOR };
        let pick = Pick::new(layer, channels, reason);
        Color { view: view_of(layer), layer, pick, others: Vec::new() }
    };
    let missing = match named(layers, name) {
        Ok(found) => {
            let named = |layer: &&'a Layer| Ok(color(layer, color_channels(layer)?));
            return found.iter().map(named).collect();
        }
        Err(problem) => problem,
    };
    if let Some(view) = views.iter().find(|view| view.name == Some(name)) {
        return find_color(view).map(|color| vec![color]);
    }
    let (layer, place) = channel(parts, layers, name).ok_or(missing)?;
    let letter = name.rsplit('.').next().unwrap_or(name);
    check_gray(conventions::data(letter)).map_err(|what| {
        Problem::Layers(format!("channel `{}` holds {what}, not light", escaped(name)))
    })?;
    let mut color = color(layer, [place; 3]);
    color.pick = Pick { layer: name.into(), pass: name.into(), ..color.pick };
    Ok(vec![color])
}

/// The reason given for a single channel.
const AS_GRAY: &str = "as asked for, as gray";

/// The channels to denoise in a layer that the caller named.
fn color_channels(layer: &Layer) -> Result<[Place; 3], Problem> {
    if let Some(channels) = layer.rgb().or_else(|| layer.xyz()) {
        return Ok(channels);
    }
    let place = layer.single().ok_or_else(|| not_three(layer))?;
    check_gray(layer.data()).map_err(|what| {
        let letters: Vec<_> = layer.channels.iter().map(|(letter, _)| escaped(letter)).collect();
        Problem::Layers(format!(
            "layer `{}` has the channels {} and holds {what}, not light",
            escaped(layer.shown()),
            letters.join(", ")
        ))
    })?;
    Ok([place; 3])
}

/// Refuses a channel as gray light if it holds noise-free data.
fn check_gray(data: Option<&'static str>) -> Result<(), &'static str> {
    let noisy = ["occlusion", "shadows", "mist", "alpha"];
    data.filter(|what| !noisy.contains(what)).map_or(Ok(()), Err)
}

/// Finds the color of every view, and says which views have none.
fn found_colors<'a>(views: &'a [View<'a>]) -> Result<(Vec<Color<'a>>, Vec<String>), Problem> {
    let (mut colors, mut left_out, mut first) = (Vec::new(), Vec::new(), None);
    for view in views {
        match find_color(view) {
            Ok(color) => colors.push(color),
            Err(problem) => {
                let has_rgb = view.layers.iter().any(|layer| layer.rgb().is_some());
                if let Some(name) = view.name.filter(|_| has_rgb) {
                    let name = escaped(name);
                    left_out.push(format!("the view `{name}` stays as it is: it {problem}"));
                }
                first.get_or_insert(problem);
            }
        }
    }
    match first {
        Some(problem) if colors.is_empty() => Err(problem),
        _ => Ok((colors, left_out)),
    }
}

/// The colors of the views that stay untouched because the caller named another color.
fn colors_of_others(views: &[View<'_>], chosen: &[Color<'_>]) -> Vec<String> {
    let denoised: HashSet<_> = chosen.iter().map(|color| color.view.name).collect();
    let others = views.iter().filter(|view| !denoised.contains(&view.name));
    others.filter_map(|view| find_color(view).ok()).map(|color| color.pick.layer).collect()
}

/// Finds a view's color layer, with the reason and the other layers of the same convention.
fn find_color<'a>(view: &'a View<'a>) -> Result<Color<'a>, Problem> {
    let layers = &view.layers;
    let with_rgb = || layers.iter().filter_map(|layer| Some((*layer, layer.rgb()?)));
    let homes = homes_with_features(layers);
    let known = |(layer, channels): (&'a Layer, _)| {
        layer.convention(conventions::COLOR).map(|index| (index, layer, channels))
    };
    let known: Vec<_> = with_rgb().filter_map(known).collect();
    let best = known.iter().min_by_key(|(index, layer, _)| (*index, rank(&homes, layer)));
    if let Some(&(convention, layer, channels)) = best {
        let pick = Pick::new(layer, channels, conventions::COLOR[convention].whose);
        let alike = known.iter().filter(|(other, ..)| *other == convention);
        let others = alike.map(|(_, other, _)| *other).filter(|other| *other != layer).collect();
        return Ok(Color { view, layer, pick, others });
    }
    let rest: Vec<_> = with_rgb().filter(|(layer, _)| layer.data().is_none()).collect();
    let with_alpha: Vec<_> = rest.iter().filter(|(layer, _)| layer.alpha().is_some()).collect();
    let ((layer, channels), reason) = match (rest.as_slice(), with_alpha.as_slice()) {
        ([only], _) => (*only, "the only layer that can be the color"),
        (_, [only]) => (**only, "the only layer with R, G, B and alpha"),
        _ => return Err(no_color(layers, &rest.iter().map(|(l, _)| *l).collect::<Vec<_>>())),
    };
    Ok(Color { view, layer, pick: Pick::new(layer, channels, reason), others: Vec::new() })
}

/// The view layers with an albedo or a normal, by name.
fn homes_with_features<'a>(layers: &[&'a Layer]) -> HashSet<&'a str> {
    let is = |l: &Layer, table| l.convention(table).is_some();
    let is_feature = |l: &&&Layer| is(l, conventions::ALBEDO) || is(l, conventions::NORMAL);
    layers.iter().filter(is_feature).map(|l| l.pass_name().0).collect()
}

/// Orders layers of one convention, preferred first: a view layer with albedo or normal is the one
/// meant for denoising, and the output of Blender's compositor may be filtered.
fn rank(homes_with_features: &HashSet<&str>, color: &Layer) -> (bool, bool) {
    let home = color.pass_name().0;
    (conventions::simple(home) == "composite", !homes_with_features.contains(home))
}

fn no_color(layers: &[&Layer], candidates: &[&Layer]) -> Problem {
    let can_be_gray = |l: &&Layer| l.single().is_some() && check_gray(l.data()).is_ok();
    let has_luminance = layers.iter().any(|l| l.channels.iter().any(|(letter, _)| letter == "Y"));
    let all = list(layers.iter().copied());
    match candidates.len() {
        0 if has_luminance => Problem::AmbiguousColor(format!(
            "has luminance (Y) but no layer with R, G and B; a single channel is denoised as gray \
             on request; its layers are {all}"
        )),
        0 if layers.iter().any(can_be_gray) => Problem::AmbiguousColor(format!(
            "has no layer with R, G and B; a single channel is denoised as gray on request; its \
             layers are {all}"
        )),
        0 => Problem::Layers(format!("has no layer with R, G and B; its layers are {all}")),
        n => Problem::AmbiguousColor(format!(
            "has {n} layers that could be the color: {}",
            listed(candidates.iter().map(|layer| layer.shown()))
        )),
    }
}

/// The combined layer in the same view layer, if the color is its noisy image.
fn combined_beside<'a>(layers: &[&'a Layer], noisy: &Layer) -> Option<(&'a Layer, Pick)> {
    let (home, pass) = noisy.pass_name();
    let is_combined = |l: &&&Layer| {
        let (prefix, name) = l.pass_name();
        prefix == home && conventions::simple(name) == "combined"
    };
    let combined = layers.iter().filter(|_| conventions::simple(pass) == "noisyimage");
    let combined = combined.into_iter().find(is_combined)?;
    let channels = combined.rgb()?;
    Some((combined, Pick::new(combined, channels, "Blender's combined pass")))
}

impl Choice {
    /// Drops layers that were found by name and fail `check`. Layers that the caller named stay.
    pub(super) fn leave_out_unusable(&mut self, check: impl Fn(&Pick) -> Result<(), Problem>) {
        let left_out = &mut self.left_out;
        let mut usable = |pick: &Pick| match check(pick) {
            Err(problem) if pick.reason != ASKED_FOR => {
                left_out.push(format!("`{}` is left out: {problem}", escaped(&pick.layer)));
                false
            }
            _ => true,
        };
        self.albedo.take_if(|pick| !usable(pick));
        self.normal.take_if(|pick| !usable(pick));
        self.layers.retain(usable);
    }

    /// Records that motion vectors are not used.
    ///
    /// # Errors
    /// If the caller named them.
    pub(super) fn leave_out_motion(&mut self, pick: &MotionPick) -> Result<(), Problem> {
        let layer = escaped(&pick.layer);
        let what = format!(
            "the motion vectors `{layer}` hold integers or cover another rectangle than the color"
        );
        if pick.reason == ASKED_FOR {
            return Err(Problem::Layers(what));
        }
        self.left_out.push(format!("{what}; they are left out"));
        Ok(())
    }

    /// All layers to read: the color, then albedo, normal and the further ones.
    pub(super) fn picks(&self) -> impl Iterator<Item = &Pick> {
        [&self.color].into_iter().chain(&self.albedo).chain(&self.normal).chain(&self.layers)
    }

    /// All color layers to write: the target, then the further ones.
    pub(super) fn targets(&self) -> impl Iterator<Item = &Pick> {
        [&self.target].into_iter().chain(&self.layers)
    }
}
