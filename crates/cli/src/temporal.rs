//! `--temporal`: averages each denoised frame of an animation with the frames around it.
//!
//! Frames wait here until the ones after them are denoised too.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::console::Console;
use wgdenoise::Image;
use wgdenoise_files::{Denoised, Picture, View, escaped};
use wgdenoise_temporal::{Convention, Evidence, Motion, Offsets, Part, Shot, agreement, mean};

/// A frame's position in its animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    /// Index of the input.
    pub(crate) sequence: usize,
    pub(crate) frame: i64,
}

/// A frame that has been denoised.
#[derive(Debug)]
pub(crate) struct Held<T> {
    pub(crate) number: Number,
    pub(crate) picture: Arc<Picture>,
    /// One result per view.
    pub(crate) results: Vec<Denoised>,
    /// The caller's data; `None` for a frame that only others need.
    pub(crate) tag: Option<T>,
}

/// A frame that others are averaged with.
#[derive(Debug)]
struct Waiting<T> {
    frame: Held<T>,
    /// One entry per view.
    views: Vec<Shown>,
}

/// A view in the form that is compared and averaged.
#[derive(Debug)]
struct Shown {
    shot: Shot,
    /// The alpha as a gray image.
    alpha: Option<Image>,
}

/// The frames that others still need.
#[derive(Debug)]
pub(crate) struct Animation<T> {
    /// How many frames on either side count.
    reach: usize,
    held: VecDeque<Waiting<T>>,
    /// Offsets between each held frame and the one after it in `held`, by view.
    ways: VecDeque<Vec<Option<Ways>>>,
    /// How many of the held frames are finished.
    finished: usize,
    /// What this sequence's frames reveal about their motion vectors.
    evidence: BTreeMap<Vectors, Evidence>,
}

/// Offsets from a frame to the next one, and back.
#[derive(Debug)]
struct Ways {
    next: Offsets,
    previous: Offsets,
}

/// Motion vectors of one kind.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Vectors {
    towards: Towards,
    layer: String,
    /// Vectors per pixel.
    count: usize,
}

/// The frame that vectors lead towards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Towards {
    Previous,
    Next,
}

impl Towards {
    fn name(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Next => "next",
        }
    }

    fn opposite(self) -> Self {
        match self {
            Self::Previous => Self::Next,
            Self::Next => Self::Previous,
        }
    }
}

impl<T> Animation<T> {
    pub(crate) fn new(reach: usize) -> Self {
        let (held, ways) = (VecDeque::new(), VecDeque::new());
        Self { reach, held, ways, finished: 0, evidence: BTreeMap::new() }
    }

    /// Takes the next frame; returns the frames that this finishes, in order.
    pub(crate) fn push(&mut self, frame: Held<T>, console: &Console) -> Vec<Held<T>> {
        let is_other = |last: &Waiting<T>| last.frame.number.sequence != frame.number.sequence;
        let ends = self.held.back().is_some_and(is_other);
        let mut done = if ends { self.finish(console) } else { Vec::new() };
        let complete = frame.number.frame - self.reach as i64;
        let frame = Waiting::new(frame);
        if let Some(last) = self.held.pop_back() {
            let views = 0..last.views.len();
            let ways = views.map(|view| self.ways([&last, &frame], view, console)).collect();
            self.ways.push_back(ways);
            self.held.push_back(last);
        }
        self.held.push_back(frame);
        while self.held[self.finished].frame.number.frame <= complete {
            done.extend(self.finish_one());
        }
        done
    }

    /// Finishes the remaining frames of a sequence.
    pub(crate) fn finish(&mut self, console: &Console) -> Vec<Held<T>> {
        let rest = self.finished..self.held.len();
        let done = rest.filter_map(|_| self.finish_one()).collect();
        for (vectors, _) in self.evidence.iter().filter(|(_, evidence)| evidence.is_lacking()) {
            if !self.is_reversed(vectors) {
                console.notice_once("", &vectors.unreadable());
            }
        }
        *self = Self::new(self.reach);
        done
    }

    /// Finishes the first unfinished frame: returns it averaged, unless only others need it. Drops
    /// frames that no other needs.
    fn finish_one(&mut self) -> Option<Held<T>> {
        let at = self.finished;
        let Held { number, ref picture, ref mut tag, .. } = self.held[at].frame;
        let (picture, tag) = (Arc::clone(picture), tag.take());
        let done = tag.map(|tag| {
            let views = 0..self.held[at].views.len();
            let results = views.map(|view| self.averaged(at, view)).collect();
            Held { number, picture, results, tag: Some(tag) }
        });
        self.finished += 1;
        let oldest = number.frame + 1 - self.reach as i64;
        while self.finished > 0 && self.held[0].frame.number.frame < oldest {
            self.held.pop_front();
            self.ways.pop_front();
            self.finished -= 1;
        }
        done
    }

    /// Averages a view of the frame at an index with the frames around it.
    fn averaged(&self, at: usize, view: usize) -> Denoised {
        let mut others = self.chain(at, view, Towards::Previous);
        others.extend(self.chain(at, view, Towards::Next));
        let parts: Vec<_> = others.iter().map(|other| self.part(other, view)).collect();
        let own = &self.held[at];
        let mut averaged = mean(&own.images(view), &parts).into_iter();
        let layers = own.frame.results[view].layers.len();
        Denoised {
            color: averaged.next().expect("the color is the first image"),
            layers: averaged.by_ref().take(layers).collect(),
            alpha: averaged.next().map(|alpha| alpha.pixels().iter().map(|p| p[0]).collect()),
        }
    }

    fn part<'a>(&'a self, other: &'a Other, view: usize) -> Part<'a> {
        let images = self.held[other.index].images(view);
        Part { images, offsets: &other.offsets, agreement: &other.agreement }
    }

    /// The frames to one side that follow without a gap, and the offsets there and back.
    fn chain(&self, at: usize, view: usize, towards: Towards) -> Vec<Other> {
        let mut found: Vec<Other> = Vec::new();
        for _ in 0..self.reach {
            let from = found.last().map_or(at, |other| other.index);
            let Some((index, [to, back])) = self.neighbor(from, view, towards) else { break };
            let (to, back) = match found.last() {
                Some(before) => (before.offsets.then(to), back.then(&before.back)),
                None => (to.clone(), back.clone()),
            };
            let [own, other] = [at, index].map(|i| &self.held[i].views[view].shot);
            let agreement = agreement(own, other, &to, Some(&back));
            found.push(Other { index, offsets: to, back, agreement });
        }
        found
    }

    /// The index of the frame before or after, the offsets there, and those back.
    fn neighbor(
        &self,
        from: usize,
        view: usize,
        towards: Towards,
    ) -> Option<(usize, [&Offsets; 2])> {
        let between = |first: usize| self.ways.get(first)?.get(view)?.as_ref();
        match towards {
            Towards::Previous => {
                let index = from.checked_sub(1)?;
                between(index).map(|ways| (index, [&ways.previous, &ways.next]))
            }
            Towards::Next => between(from).map(|ways| (from + 1, [&ways.next, &ways.previous])),
        }
    }

    /// The offsets between two frames, if one follows the other and both show the same images.
    fn ways(
        &mut self,
        [first, second]: [&Waiting<T>; 2],
        view: usize,
        console: &Console,
    ) -> Option<Ways> {
        let follows = second.frame.number.frame == first.frame.number.frame + 1;
        if !follows || !shows_the_same([first, second], view) {
            return None;
        }
        let next = self.read([first, second], view, Towards::Next);
        let previous = self.read([second, first], view, Towards::Previous);
        if next.vectors.is_none() || previous.vectors.is_none() {
            console.notice_once("", WITHOUT_MOTION);
        }
        Some(self.settled(next, previous, console))
    }

    /// Reads a frame's motion vectors as offsets towards another frame.
    fn read(&mut self, [own, other]: [&Waiting<T>; 2], view: usize, towards: Towards) -> Reading {
        let seen = &own.frame.picture.views()[view];
        let Some((layer, motion)) = motion(seen) else {
            let offsets = Offsets::still(seen.color().width(), seen.color().height());
            return Reading { offsets, vectors: None };
        };
        let vectors = Vectors { towards, layer: layer.into(), count: motion.vectors() };
        let new = || Evidence::new(motion.vectors());
        let evidence = self.evidence.entry(vectors.clone()).or_insert_with(new);
        evidence.add(&motion, &own.views[view].shot, &other.views[view].shot);
        Reading { offsets: evidence.offsets(&motion), vectors: Some(vectors) }
    }

    /// Settles the offsets from two readings. A single vector per pixel leads to only one of the
    /// two frames: the other reading is wrong, and the right one's offsets, reversed, replace it.
    fn settled(&self, next: Reading, previous: Reading, console: &Console) -> Ways {
        let [ahead, back] = [&next, &previous].map(|reading| self.difference_of_single(reading));
        let is_less = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| a < b);
        if is_less(back, ahead) {
            self.tell(&previous, Some(REVERSED_NEXT), console);
            Ways { next: previous.offsets.reversed(), previous: previous.offsets }
        } else if is_less(ahead, back) {
            self.tell(&next, Some(REVERSED_PREVIOUS), console);
            Ways { previous: next.offsets.reversed(), next: next.offsets }
        } else {
            self.tell(&next, None, console);
            self.tell(&previous, None, console);
            Ways { next: next.offsets, previous: previous.offsets }
        }
    }

    /// The difference that following single vectors leaves; `None` for other vectors.
    fn difference_of_single(&self, reading: &Reading) -> Option<f64> {
        let vectors = reading.vectors.as_ref().filter(|vectors| vectors.count == 1)?;
        Some(self.evidence.get(vectors)?.difference())
    }

    /// Whether vectors are ignored because reversed ones are followed.
    fn is_reversed(&self, vectors: &Vectors) -> bool {
        let other = Vectors { towards: vectors.towards.opposite(), ..vectors.clone() };
        let is_clear = |evidence: &Evidence| evidence.convention().is_some();
        vectors.count == 1 && self.evidence.get(&other).is_some_and(is_clear)
    }

    fn tell(&self, reading: &Reading, reversed: Option<&str>, console: &Console) {
        let Some(vectors) = &reading.vectors else { return };
        if let Some(convention) = self.evidence.get(vectors).and_then(Evidence::convention) {
            console.notice_once("", &vectors.read_as(convention));
            if let Some(sentence) = reversed {
                console.notice_once("", sentence);
            }
        }
    }
}

/// Whether a view of two frames has the same window, layers and alpha.
fn shows_the_same<T>(frames: [&Waiting<T>; 2], view: usize) -> bool {
    let shown = frames.map(|Waiting { frame, .. }| {
        let (seen, result) = (frame.picture.views().get(view)?, frame.results.get(view)?);
        let layers: Vec<_> = seen.layers().iter().map(|layer| &layer.name).collect();
        let place = (result.color.size(), seen.corner());
        Some((seen.name(), place, layers, result.layers.len(), result.alpha.is_some()))
    });
    shown[0].is_some() && shown[0] == shown[1]
}

/// A frame to average with, and the offsets there and back.
struct Other {
    index: usize,
    offsets: Offsets,
    back: Offsets,
    agreement: Vec<f32>,
}

/// A frame's motion vectors, read as leading towards another frame.
struct Reading {
    offsets: Offsets,
    /// `None` if there are none, so that nothing moves.
    vectors: Option<Vectors>,
}

const REVERSED_NEXT: &str = "motion to the next frame: that to the previous frame, reversed";
const REVERSED_PREVIOUS: &str = "motion to the previous frame: that to the next frame, reversed";

const WITHOUT_MOTION: &str =
    "no motion vectors: only what stays in place is averaged with the frames around it";

impl Vectors {
    fn read_as(&self, convention: Convention) -> String {
        let (towards, layer) = (self.towards.name(), escaped(&self.layer));
        format!("motion to the {towards} frame from `{layer}`: {convention}")
    }

    fn unreadable(&self) -> String {
        let (towards, layer) = (self.towards.name(), escaped(&self.layer));
        format!(
            "no interpretation of the motion vectors `{layer}` clearly finds the same surfaces in \
             the {towards} frame: only pixels that move by less than a pixel are averaged"
        )
    }
}

/// A view's motion vectors and the name of their layer.
fn motion(view: &View) -> Option<(&str, Motion)> {
    let layer = view.motion()?;
    let (width, height) = view.color().size();
    Some((&layer.name, Motion::new(width, height, layer.planes.clone())?))
}

impl<T> Waiting<T> {
    fn new(frame: Held<T>) -> Self {
        let views = frame.picture.views().iter().zip(&frame.results);
        let views = views.map(|(view, result)| Shown::new(view, result)).collect();
        Self { frame, views }
    }

    /// The images to average in a view: the color, the layers and the alpha.
    fn images(&self, view: usize) -> Vec<&Image> {
        let result = &self.frame.results[view];
        let light = [&result.color].into_iter().chain(&result.layers);
        light.chain(&self.views[view].alpha).collect()
    }
}

impl Shown {
    fn new(view: &View, result: &Denoised) -> Self {
        let (width, height) = result.color.size();
        let gray = |alpha: &Vec<f32>| {
            let pixels = alpha.iter().map(|a| [*a; 3]).collect();
            Image::new(width, height, pixels).expect("the alpha has the color's size")
        };
        let shot = Shot::new(&result.color, view.albedo(), view.normal());
        Self { shot, alpha: result.alpha.as_ref().map(gray) }
    }
}
