//! Finds the convention that motion vectors follow, from the frames they link.

use rayon::prelude::*;

use crate::convention::{Convention, Motion};
use crate::offsets::end;
use crate::sample::Four;
use crate::shot::Feature;
use crate::{Offsets, Shot};

/// Evidence from pairs of frames for the convention of motion vectors.
///
/// One pair may be ambiguous: a pan cannot tell up from down, and a slow start or a cut tells
/// nothing. So every pair counts, and the convention that leads to the most similar surfaces wins.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// For each convention, the mean difference at the ends of its offsets, summed over the pairs.
    differences: Vec<(Convention, f64)>,
    /// Pairs compared so far.
    pairs: u32,
    /// Whether any pair was clear.
    is_clear: bool,
    /// Whether any pair moves far enough for the convention to matter.
    matters: bool,
}

/// Most pixels compared per pair.
const SAMPLES: usize = 20_000;
/// A pair is clear if following the offsets leaves at most this fraction of the difference that
/// staying in place leaves.
const CLEAR: f64 = 0.75;
/// At least this many pixels must move.
const FEWEST: usize = 50;
/// Motion below this many pixels tells nothing.
const LEAST: f32 = 0.25;
/// While the convention is unknown, offsets of at most this many pixels are followed.
const HARMLESS: f32 = 1.0;

impl Evidence {
    /// Starts without evidence, for one or two vectors per pixel.
    #[must_use]
    pub fn new(vectors: usize) -> Self {
        let differences = Convention::all(vectors).map(|convention| (convention, 0.0)).collect();
        Self { differences, pairs: 0, is_clear: false, matters: false }
    }

    /// Adds a pair of frames: tests whether the motion of `own` leads to the same surfaces in
    /// `other`, judged by the albedo and normals that both have, or by light if they share neither.
    ///
    /// # Panics
    /// If the sizes differ, or `motion` has fewer vectors per pixel than [`new`](Self::new) was
    /// given.
    pub fn add(&mut self, motion: &Motion, own: &Shot, other: &Shot) {
        let size = motion.size();
        assert!([own.size(), other.size()] == [size; 2], "sizes");
        self.matters |= self.best().offsets(motion).up_to(HARMLESS).unseen() >= FEWEST;
        let seen = Seen::new(own, other);
        let places = places(motion, &seen);
        if places.is_empty() {
            return;
        }
        self.pairs += 1;
        self.differences.par_iter_mut().for_each(|(convention, sum)| {
            let ends = places.iter().map(|place| f64::from(place.end(*convention, motion, &seen)));
            *sum += ends.sum::<f64>() / places.len() as f64;
        });
        self.is_clear |= is_clear(self.best(), &places, motion, &seen);
    }

    /// The convention, or `None` while it is unknown.
    #[must_use]
    pub fn convention(&self) -> Option<Convention> {
        self.is_clear.then(|| self.best())
    }

    /// Whether pixels so far are left out because the convention is unknown.
    #[must_use]
    pub fn is_lacking(&self) -> bool {
        !self.is_clear && self.matters
    }

    /// Converts motion vectors to offsets. While the convention is unknown, keeps only short ones,
    /// for which it hardly matters.
    ///
    /// # Panics
    /// If `motion` has fewer vectors per pixel than [`new`](Self::new) was given.
    #[must_use]
    pub fn offsets(&self, motion: &Motion) -> Offsets {
        let offsets = self.best().offsets(motion);
        if self.is_clear { offsets } else { offsets.up_to(HARMLESS) }
    }

    /// The difference that following the vectors leaves, averaged over the pairs; infinite while
    /// the convention is unknown. If vectors may lead to the previous or to the next frame, they
    /// lead to the one with the smaller difference.
    #[must_use]
    pub fn difference(&self) -> f64 {
        if self.is_clear { self.least().1 / f64::from(self.pairs) } else { f64::INFINITY }
    }

    fn best(&self) -> Convention {
        self.least().0
    }

    fn least(&self) -> (Convention, f64) {
        let least = self.differences.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        *least.expect("there are conventions")
    }
}

/// A pixel to compare.
struct Place {
    i: usize,
    /// Its difference from the same pixel of the other frame.
    staying: f32,
}

impl Place {
    /// The difference at the end of the offset, or in place where that is outside the picture or
    /// not finite.
    fn end(&self, convention: Convention, motion: &Motion, seen: &Seen<'_>) -> f32 {
        let size = motion.size();
        let four = Four::around(end(self.i, convention.offset(motion, self.i), size.0), size);
        let difference = four.map(|four| seen.difference(self.i, &four));
        difference.filter(|difference| difference.is_finite()).unwrap_or(self.staying)
    }
}

/// Pixels across the picture with motion in any vector.
fn places(motion: &Motion, seen: &Seen<'_>) -> Vec<Place> {
    let (width, height) = motion.size();
    // Assumes the largest unit, so that no motion counts as still.
    let least = LEAST / width.max(height) as f32;
    let moves = |i: usize| motion.planes.iter().any(|p| p[i].is_finite() && p[i].abs() >= least);
    let all: Vec<_> = (0..motion.planes[0].len()).filter(|&i| moves(i)).collect();
    let step = all.len().div_ceil(SAMPLES).max(1);
    let place = |i: usize| {
        let staying = seen.difference(i, &Four::around(end(i, [0.0; 2], width), (width, height))?);
        staying.is_finite().then_some(Place { i, staying })
    };
    all.into_iter().step_by(step).filter_map(place).collect()
}

/// Whether pixels that move under a convention land on the same surfaces.
fn is_clear(convention: Convention, places: &[Place], motion: &Motion, seen: &Seen<'_>) -> bool {
    let moves = |place: &&Place| {
        let [right, down] = convention.offset(motion, place.i);
        right.hypot(down) >= LEAST
    };
    let moving: Vec<_> = places.iter().filter(moves).collect();
    let ends = moving.iter().map(|place| f64::from(place.end(convention, motion, seen)));
    let staying = moving.iter().map(|place| f64::from(place.staying));
    moving.len() >= FEWEST && ends.sum::<f64>() <= CLEAR * staying.sum::<f64>()
}

/// Two frames and the features to compare them by.
struct Seen<'a> {
    own: &'a Shot,
    other: &'a Shot,
    features: Vec<Feature>,
}

impl<'a> Seen<'a> {
    fn new(own: &'a Shot, other: &'a Shot) -> Self {
        let features = [Feature::Albedo, Feature::Normal].into_iter();
        let mut features: Vec<_> = features.filter(|f| own.has(*f) && other.has(*f)).collect();
        if features.is_empty() {
            features.push(Feature::Light);
        }
        Self { own, other, features }
    }

    fn difference(&self, i: usize, four: &Four) -> f32 {
        let pixel = self.own.compare(i, self.other, four);
        self.features.iter().map(|feature| pixel.difference(*feature)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgdenoise::Image;

    const SIZE: (u32, u32) = (48, 32);

    /// A picture without repetition, shifted right and down by whole pixels.
    fn scene([right, down]: [i32; 2]) -> Image {
        let value = |x: i32, y: i32| {
            let (x, y) = ((x - right) as f32, (y - down) as f32);
            [(x * 0.31).sin(), (y * 0.37 + x * 0.05).cos(), (x * 0.11 - y * 0.23).sin()]
        };
        let pixels = (0..SIZE.1 as i32).flat_map(|y| (0..SIZE.0 as i32).map(move |x| value(x, y)));
        Image::new(SIZE.0, SIZE.1, pixels.collect()).expect("a valid image")
    }

    fn motion(planes: &[f32]) -> Motion {
        let planes = planes.iter().map(|v| vec![*v; (SIZE.0 * SIZE.1) as usize]).collect();
        Motion::new(SIZE.0, SIZE.1, planes).expect("it fits")
    }

    fn add(evidence: &mut Evidence, planes: &[f32], to: [i32; 2]) {
        let (own, other) = (scene([0, 0]), scene(to));
        let shot = |albedo| Shot::new(albedo, Some(albedo), None);
        evidence.add(&motion(planes), &shot(&own), &shot(&other));
    }

    fn of(planes: &[f32], to: [i32; 2]) -> Evidence {
        let mut evidence = Evidence::new(planes.len() / 2);
        add(&mut evidence, planes, to);
        evidence
    }

    #[test]
    fn the_convention_that_leads_to_the_same_surface_is_found() {
        let sides = [5.0 / 48.0, 3.0 / 32.0];
        for (planes, to) in [
            (&[5.0, 3.0][..], [5, 3]),
            (&[-5.0, 3.0], [5, 3]),
            (&[5.0, -3.0, 1.0, 1.0], [5, 3]),
            (&[1.0, 1.0, -5.0, 3.0], [5, 3]),
            (&sides, [5, 3]),
            (&[-2.0 * sides[0], 2.0 * sides[1]], [5, 3]),
        ] {
            let found = of(planes, to);
            assert!(found.convention().is_some(), "{planes:?}: {found:?}");
            for offset in found.offsets(&motion(planes)).pixels() {
                assert!(
                    (offset[0] - 5.0).abs() < 1e-4 && (offset[1] - 3.0).abs() < 1e-4,
                    "{planes:?}"
                );
            }
        }
    }

    #[test]
    fn what_one_pair_leaves_open_others_decide() {
        let mut evidence = of(&[-4.0, 0.0], [4, 0]);
        add(&mut evidence, &[0.0, 0.0], [0, 0]);
        add(&mut evidence, &[7.0, 5.0], [20, -13]);
        add(&mut evidence, &[0.0, -4.0], [0, 4]);
        assert_eq!(evidence.offsets(&motion(&[-4.0, -4.0])).pixels()[0], [4.0, 4.0]);
        // A cut does not make it ambiguous again.
        add(&mut evidence, &[7.0, 5.0], [20, -13]);
        assert_eq!(evidence.offsets(&motion(&[-4.0, -4.0])).pixels()[0], [4.0, 4.0]);
    }

    #[test]
    fn vectors_that_lead_nowhere_are_followed_less_than_a_pixel() {
        let found = of(&[3.0, 4.0], [-5, 1]);
        assert_eq!(found.convention(), None);
        assert_eq!(found.difference(), f64::INFINITY);
        assert!(found.offsets(&motion(&[3.0, 4.0])).pixels()[0][0].is_nan());
        let found = of(&[0.0, 0.0], [0, 0]);
        assert_eq!(found.convention(), None);
        assert_eq!(found.offsets(&motion(&[0.0, 0.0])), Offsets::still(48, 32));
        let found = of(&[f32::NAN, f32::INFINITY], [0, 0]);
        assert!(found.offsets(&motion(&[f32::NAN, 0.0])).pixels()[0][0].is_nan());
    }

    #[test]
    fn the_right_reading_leaves_the_smaller_difference_however_many_pairs_there_are() {
        let (mut right, wrong) = (of(&[5.0, 3.0], [5, 3]), of(&[5.0, 4.0], [5, 3]));
        for _ in 0..50 {
            add(&mut right, &[5.0, 3.0], [5, 3]);
        }
        let [right, wrong] = [right, wrong].map(|evidence| evidence.difference());
        assert!(right < wrong && wrong.is_finite(), "{right}, {wrong}");
    }

    #[test]
    fn without_features_the_light_decides() {
        let (own, other) = (scene([0, 0]), scene([-4, 0]));
        let bare = |color| Shot::new(color, None, None);
        let mut evidence = Evidence::new(1);
        evidence.add(&motion(&[4.0, 0.0]), &bare(&own), &bare(&other));
        assert_eq!(evidence.offsets(&motion(&[4.0, 0.0])).pixels()[0][0], -4.0);
        let found = evidence.convention().expect("it is clear").to_string();
        assert!(found.starts_with("the first vector, x left and y "));
    }
}
