//! `--temporal`: each denoised frame of an animation is averaged with those around it.
//!
//! Frames wait here until those after them are denoised too.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::console::Console;
use crate::failure::Failure;
use wgdenoise::Image;
use wgdenoise_files::{Denoised, Picture, View, escaped};
use wgdenoise_temporal::{Convention, Found, Motion, Offsets, Shot, agreement, mean};

/// Where a frame is in its animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    /// Index of the input.
    pub(crate) sequence: usize,
    pub(crate) frame: i64,
}

/// A frame that has been denoised. The tag is the caller's.
#[derive(Debug)]
pub(crate) struct Held<T> {
    pub(crate) number: Number,
    pub(crate) picture: Arc<Picture>,
    /// By view.
    pub(crate) results: Vec<Denoised>,
    pub(crate) tag: Option<T>,
}

/// The frames that others still need.
#[derive(Debug)]
pub(crate) struct Animation<T> {
    /// How many frames to each side count.
    reach: usize,
    held: VecDeque<Held<T>>,
    /// How many of them are finished.
    finished: usize,
    /// To the previous and to the next frame, once they are known.
    conventions: [Option<Convention>; 2],
}

/// Towards which frame.
#[derive(Clone, Copy)]
enum Towards {
    Previous,
    Next,
}

impl Towards {
    fn opposite(self) -> Self {
        match self {
            Self::Previous => Self::Next,
            Self::Next => Self::Previous,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Next => "next",
        }
    }
}

impl<T> Animation<T> {
    pub(crate) fn new(reach: usize) -> Self {
        Self { reach, held: VecDeque::new(), finished: 0, conventions: [None; 2] }
    }

    /// Takes the next frame; returns the frames that are finished with it, in their order.
    pub(crate) fn push(
        &mut self,
        frame: Held<T>,
        console: &Console,
    ) -> Result<Vec<Held<T>>, Failure> {
        let is_next = |last: &Held<T>| last.number.sequence == frame.number.sequence;
        let mut done = match self.held.back() {
            Some(last) if !is_next(last) => self.finish(console)?,
            _ => Vec::new(),
        };
        let newest = frame.number.frame;
        self.held.push_back(frame);
        let complete = newest - self.reach as i64;
        while self.held[self.finished].number.frame <= complete {
            done.push(self.finish_one(console)?);
        }
        Ok(done)
    }

    /// The rest of the frames; no more come.
    pub(crate) fn finish(&mut self, console: &Console) -> Result<Vec<Held<T>>, Failure> {
        let mut done = Vec::new();
        while self.finished < self.held.len() {
            done.push(self.finish_one(console)?);
        }
        self.held.clear();
        self.finished = 0;
        Ok(done)
    }

    /// The first frame that is not finished, averaged; drops those that no other needs.
    fn finish_one(&mut self, console: &Console) -> Result<Held<T>, Failure> {
        let at = self.finished;
        let views = 0..self.held[at].results.len();
        let results =
            views.map(|view| self.averaged(at, view, console)).collect::<Result<_, _>>()?;
        let frame = &mut self.held[at];
        let (number, picture, tag) = (frame.number, Arc::clone(&frame.picture), frame.tag.take());
        self.finished += 1;
        let oldest = number.frame + 1 - self.reach as i64;
        while self.finished > 0 && self.held[0].number.frame < oldest {
            self.held.pop_front();
            self.finished -= 1;
        }
        Ok(Held { number, picture, results, tag })
    }

    /// A view of the frame at an index, averaged with the frames around it.
    fn averaged(&mut self, at: usize, view: usize, console: &Console) -> Result<Denoised, Failure> {
        let mut others = self.chain(at, view, Towards::Previous, console)?;
        others.extend(self.chain(at, view, Towards::Next, console)?);
        let own = &self.held[at].results[view];
        let of = |image: &dyn Fn(&Denoised) -> Image| {
            let images: Vec<_> =
                others.iter().map(|o| image(&self.held[o.index].results[view])).collect();
            let parts = images.iter().zip(&others);
            let parts: Vec<_> =
                parts.map(|(i, o)| (i, &o.offsets, o.agreement.as_slice())).collect();
            mean(&image(own), &parts)
        };
        let layers = 0..own.layers.len();
        Ok(Denoised {
            color: of(&|result| result.color.clone()),
            layers: layers.map(|i| of(&|result| result.layers[i].clone())).collect(),
            alpha: own
                .alpha
                .as_ref()
                .map(|_| of(&alpha_image).pixels().iter().map(|p| p[0]).collect()),
        })
    }

    /// The frames to one side that follow each other without a gap, and the ways there.
    fn chain(
        &mut self,
        at: usize,
        view: usize,
        towards: Towards,
        console: &Console,
    ) -> Result<Vec<Other>, Failure> {
        let mut found: Vec<Other> = Vec::new();
        for _ in 0..self.reach {
            let from = found.last().map_or(at, |other| other.index);
            let Some(index) = self.neighbor(from, view, towards) else { break };
            let [to, back] = self.ways([from, index], view, towards, console)?;
            let (to, back) = match found.last() {
                Some(before) => (before.offsets.then(&to), back.then(&before.back)),
                None => (to, back),
            };
            let [own, other] = [at, index].map(|i| shot(&self.held[i], view));
            let agreement = agreement(&own, &other, &to, Some(&back));
            found.push(Other { index, offsets: to, back, agreement });
        }
        Ok(found)
    }

    /// The index of the frame before or after, if it is there and has the same images.
    fn neighbor(&self, from: usize, view: usize, towards: Towards) -> Option<usize> {
        let (index, step) = match towards {
            Towards::Previous => (from.checked_sub(1)?, -1),
            Towards::Next => (from + 1, 1),
        };
        let (own, other) = (&self.held[from], self.held.get(index)?);
        let result = |frame: &Held<T>| {
            let result = frame.results.get(view)?;
            Some((result.color.size(), result.layers.len(), result.alpha.is_some()))
        };
        let follows = other.number.frame == own.number.frame + step;
        (follows && result(own) == result(other)).then_some(index)
    }

    /// The way from one frame to the one beside it, and back.
    fn ways(
        &mut self,
        [from, to]: [usize; 2],
        view: usize,
        towards: Towards,
        console: &Console,
    ) -> Result<[Offsets; 2], Failure> {
        let there = self.way([from, to], view, towards, console)?;
        Ok([there, self.way([to, from], view, towards.opposite(), console)?])
    }

    fn way(
        &mut self,
        [from, to]: [usize; 2],
        view: usize,
        towards: Towards,
        console: &Console,
    ) -> Result<Offsets, Failure> {
        let own = &self.held[from].picture.views()[view];
        let still = Offsets::still(own.color().width(), own.color().height());
        let Some((name, motion)) = motion(own) else {
            console.notice_once("", WITHOUT_MOTION);
            return Ok(still);
        };
        if let Some(known) = self.conventions[towards as usize] {
            return Ok(known.offsets(&motion));
        }
        let [own, other] = [from, to].map(|i| shot(&self.held[i], view));
        match Convention::find(&motion, &own, &other) {
            Found::Still => Ok(still),
            Found::Nothing => Err(unreadable(name, towards)),
            Found::Reads(convention) => {
                console.notice_once("", &read_as(name, towards, convention));
                self.conventions[towards as usize] = Some(convention);
                Ok(convention.offsets(&motion))
            }
        }
    }
}

/// A frame that is averaged with another, and the ways there and back.
struct Other {
    index: usize,
    offsets: Offsets,
    back: Offsets,
    agreement: Vec<f32>,
}

const WITHOUT_MOTION: &str =
    "no motion vectors: only what stays in place is averaged with the frames around it";

fn read_as(name: &str, towards: Towards, convention: Convention) -> String {
    format!("motion to the {} frame from `{}`: {convention}", towards.name(), escaped(name))
}

fn unreadable(name: &str, towards: Towards) -> Failure {
    Failure::Work(format!(
        "the motion vectors `{}` do not lead to the same surfaces in the {} frame, however they are \
         read; name others with --motion, or leave out --temporal",
        escaped(name),
        towards.name()
    ))
}

/// The motion vectors of a view and their layer's name.
fn motion(view: &View) -> Option<(&str, Motion)> {
    let layer = view.motion()?;
    let (width, height) = view.color().size();
    Some((&layer.name, Motion::new(width, height, layer.planes.clone())?))
}

fn shot<T>(frame: &Held<T>, view: usize) -> Shot<'_> {
    let seen = &frame.picture.views()[view];
    Shot { color: &frame.results[view].color, albedo: seen.albedo(), normal: seen.normal() }
}

/// The alpha as a gray image.
fn alpha_image(result: &Denoised) -> Image {
    let (width, height) = result.color.size();
    let alpha = result.alpha.iter().flatten().map(|a| [*a; 3]).collect();
    Image::new(width, height, alpha).expect("the alpha has the color's size")
}
