//! How a renderer means its motion vectors.

use std::fmt;

use wgdenoise::Image;

use crate::sample::{Four, smoothed};
use crate::{Offsets, Shot};

/// Motion vectors of a frame as its file has them: one or two vectors a pixel.
#[derive(Clone, Debug)]
pub struct Motion {
    width: u32,
    height: u32,
    planes: Vec<Vec<f32>>,
}

impl Motion {
    /// From two or four planes, row by row: x and y, and x and y of the second vector. `None` if their
    /// number or sizes do not fit.
    #[must_use]
    pub fn new(width: u32, height: u32, planes: Vec<Vec<f32>>) -> Option<Self> {
        let pixels = width as usize * height as usize;
        let fits = planes.iter().all(|plane| plane.len() == pixels);
        (fits && matches!(planes.len(), 2 | 4)).then_some(Self { width, height, planes })
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }
}

/// How to read motion vectors as offsets to a frame.
///
/// Renderers differ in all of it: Blender's `Vector` holds the way from the previous frame's place to
/// this one's with y up, and the way to the next frame's place; others store pixels with y down, or
/// shares of the picture's sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convention {
    /// The first of the two planes.
    plane: usize,
    unit: Unit,
    /// Whether positive values lead left and up.
    is_left: bool,
    is_up: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Pixel,
    /// The picture's sides.
    Side,
    /// Half of the picture's sides.
    HalfSide,
}

/// What [`Convention::find`] finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// Nothing moves, so every convention fits.
    Still,
    /// This one leads to the same surfaces.
    Reads(Convention),
    /// None leads closer to the same surfaces than staying in place does.
    Nothing,
}

/// Most pixels to compare.
const SAMPLES: usize = 20_000;
/// A convention must leave at most this share of the difference that staying in place leaves.
const CLEAR: f64 = 0.75;
/// Smaller motion, in pixels, tells nothing.
const LEAST: f32 = 0.25;

impl Convention {
    /// The convention by which the motion of `own` leads to the same surfaces in `other`: the one that
    /// leaves the least difference of albedo and normals, or of light if a frame lacks them.
    ///
    /// # Panics
    /// If the sizes differ.
    #[must_use]
    pub fn find(motion: &Motion, own: &Shot<'_>, other: &Shot<'_>) -> Found {
        let size = motion.size();
        assert!([own.color.size(), other.color.size()] == [size; 2], "sizes");
        let places = moving(motion);
        if places.is_empty() {
            return Found::Still;
        }
        let seen = Seen::of(own, other);
        let score =
            |convention: Self| (seen.difference(&places, &convention.offsets(motion)), convention);
        let scores = Self::all(motion.planes.len()).map(score);
        let best = scores.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are some");
        let staying = seen.difference(&places, &Offsets::still(size.0, size.1));
        if best.0 <= CLEAR * staying { Found::Reads(best.1) } else { Found::Nothing }
    }

    fn all(planes: usize) -> impl Iterator<Item = Self> {
        let flags = [(false, false), (false, true), (true, false), (true, true)];
        let units = [Unit::Pixel, Unit::Side, Unit::HalfSide];
        (0..planes).step_by(2).flat_map(move |plane| {
            units.into_iter().flat_map(move |unit| {
                flags.map(|(is_left, is_up)| Self { plane, unit, is_left, is_up })
            })
        })
    }

    /// The offsets that the vectors stand for.
    #[must_use]
    pub fn offsets(&self, motion: &Motion) -> Offsets {
        let (width, height) = motion.size();
        let [right, down] = self.factors((width, height));
        let [x, y] = [&motion.planes[self.plane], &motion.planes[self.plane + 1]];
        let pixels = x.iter().zip(y).map(|(x, y)| [x * right, y * down]).collect();
        Offsets { width, height, pixels }
    }

    /// From a vector to pixels right and down.
    fn factors(&self, (width, height): (u32, u32)) -> [f32; 2] {
        let sign = |is_negative: bool| if is_negative { -1.0 } else { 1.0 };
        let scale = match self.unit {
            Unit::Pixel => [1.0; 2],
            Unit::Side => [width as f32, height as f32],
            Unit::HalfSide => [width as f32 / 2.0, height as f32 / 2.0],
        };
        [scale[0] * sign(self.is_left), scale[1] * sign(self.is_up)]
    }
}

impl fmt::Display for Convention {
    /// Such as `the second vector, x left and y down, in pixels`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let which = if self.plane == 0 { "first" } else { "second" };
        let x = if self.is_left { "left" } else { "right" };
        let y = if self.is_up { "up" } else { "down" };
        let unit = match self.unit {
            Unit::Pixel => "pixels",
            Unit::Side => "sides of the picture",
            Unit::HalfSide => "half sides of the picture",
        };
        write!(f, "the {which} vector, x {x} and y {y}, in {unit}")
    }
}

/// Pixels spread over the picture that move in any vector.
fn moving(motion: &Motion) -> Vec<usize> {
    // In the largest unit, so that none is taken for still.
    let moves = |i: usize| {
        motion.planes.iter().any(|plane| plane[i].is_finite() && plane[i] != 0.0)
            && motion
                .planes
                .iter()
                .any(|plane| plane[i].abs() * motion.width.max(motion.height) as f32 >= LEAST)
    };
    let all: Vec<_> = (0..motion.planes[0].len()).filter(|&i| moves(i)).collect();
    let step = all.len().div_ceil(SAMPLES).max(1);
    all.into_iter().step_by(step).collect()
}

/// What two frames show, image by image.
struct Seen(Vec<[Vec<[f32; 3]>; 2]>);

impl Seen {
    fn of(own: &Shot<'_>, other: &Shot<'_>) -> Self {
        let pair = |a: Option<&Image>, b: Option<&Image>| Some([smoothed(a?), smoothed(b?)]);
        let features = [pair(own.albedo, other.albedo), pair(own.normal, other.normal)];
        let features: Vec<_> = features.into_iter().flatten().collect();
        if features.is_empty() {
            return Self(vec![[smoothed(own.color), smoothed(other.color)]]);
        }
        Self(features)
    }

    /// The mean difference at the ends of the offsets; infinite if most lead out of the picture.
    fn difference(&self, places: &[usize], offsets: &Offsets) -> f64 {
        let inside = places.iter().filter_map(|&i| Some((i, offsets.four(i)?)));
        let found: Vec<_> =
            inside.map(|(i, four)| self.at(i, &four)).filter(|d| d.is_finite()).collect();
        if found.len() * 2 < places.len() {
            return f64::INFINITY;
        }
        found.iter().map(|d| f64::from(*d)).sum::<f64>() / found.len() as f64
    }

    fn at(&self, i: usize, four: &Four) -> f32 {
        let difference = |[own, other]: &[Vec<[f32; 3]>; 2]| {
            let other = four.mean(other);
            own[i].iter().zip(other).map(|(a, b)| (a - b).abs()).sum::<f32>()
        };
        self.0.iter().map(difference).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (48, 32);

    /// A picture without repetition, moved right and down by whole pixels.
    fn scene([right, down]: [i32; 2]) -> Image {
        let value = |x: i32, y: i32| {
            let (x, y) = ((x - right) as f32, (y - down) as f32);
            [(x * 0.31).sin(), (y * 0.37 + x * 0.05).cos(), (x * 0.11 - y * 0.23).sin()]
        };
        let pixels = (0..SIZE.1 as i32).flat_map(|y| (0..SIZE.0 as i32).map(move |x| value(x, y)));
        Image::new(SIZE.0, SIZE.1, pixels.collect()).expect("a valid image")
    }

    fn find(planes: &[f32], to: [i32; 2]) -> (Motion, Found) {
        let planes = planes.iter().map(|v| vec![*v; (SIZE.0 * SIZE.1) as usize]).collect();
        let motion = Motion::new(SIZE.0, SIZE.1, planes).expect("it fits");
        let (own, other) = (scene([0, 0]), scene(to));
        let shot = |albedo| Shot { color: albedo, albedo: Some(albedo), normal: None };
        let found = Convention::find(&motion, &shot(&own), &shot(&other));
        (motion, found)
    }

    #[test]
    fn the_reading_that_leads_to_the_same_surface_is_found() {
        let sides = [5.0 / 48.0, 3.0 / 32.0];
        for (planes, to) in [
            (&[5.0, 3.0][..], [5, 3]),
            (&[-5.0, 3.0], [5, 3]),
            (&[5.0, -3.0, 1.0, 1.0], [5, 3]),
            (&[1.0, 1.0, -5.0, 3.0], [5, 3]),
            (&sides, [5, 3]),
            (&[-2.0 * sides[0], 2.0 * sides[1]], [5, 3]),
        ] {
            let (motion, found) = find(planes, to);
            let Found::Reads(convention) = found else { panic!("{planes:?}: {found:?}") };
            for offset in convention.offsets(&motion).pixels() {
                assert!(
                    (offset[0] - 5.0).abs() < 1e-4 && (offset[1] - 3.0).abs() < 1e-4,
                    "{planes:?}"
                );
            }
        }
    }

    #[test]
    fn vectors_that_lead_nowhere_are_not_read() {
        assert_eq!(find(&[3.0, 4.0], [-5, 1]).1, Found::Nothing);
        assert_eq!(find(&[0.0, 0.0], [0, 0]).1, Found::Still);
    }

    #[test]
    fn without_features_the_light_decides() {
        let motion =
            Motion::new(48, 32, vec![vec![4.0; 48 * 32], vec![0.0; 48 * 32]]).expect("it fits");
        let (own, other) = (scene([0, 0]), scene([-4, 0]));
        let bare = |color| Shot { color, albedo: None, normal: None };
        let Found::Reads(convention) = Convention::find(&motion, &bare(&own), &bare(&other)) else {
            panic!("nothing was found")
        };
        assert_eq!(convention.offsets(&motion).pixels()[0][0], -4.0);
        assert!(convention.to_string().starts_with("the first vector, x left and y "));
    }

    #[test]
    fn two_or_four_planes_of_the_size_are_motion() {
        let planes = |count, pixels| vec![vec![0.0; pixels]; count];
        for (count, pixels, fits) in [(2, 6, true), (4, 6, true), (3, 6, false), (2, 5, false)] {
            assert_eq!(
                Motion::new(3, 2, planes(count, pixels)).is_some(),
                fits,
                "{count}, {pixels}"
            );
        }
    }
}
