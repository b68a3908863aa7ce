//! The conventions renderers follow for motion vectors.

use std::fmt;

use crate::Offsets;

/// A frame's motion vectors as the file stores them: one or two per pixel.
#[derive(Clone, Debug)]
pub struct Motion {
    width: u32,
    height: u32,
    pub(crate) planes: Vec<Vec<f32>>,
}

impl Motion {
    /// Takes two or four planes, row by row: x and y, then x and y of the second vector. Returns
    /// `None` if their number or sizes do not fit.
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

    /// Vectors per pixel: one or two.
    #[must_use]
    pub fn vectors(&self) -> usize {
        self.planes.len() / 2
    }
}

/// How to convert motion vectors to offsets to another frame.
///
/// Renderers differ in every respect. Blender's `Vector` leads to the surface's place in the
/// previous frame; its second vector leads from the place in the next frame back to this one. Both
/// are in pixels with y up. Others store pixels with y down, or fractions of the picture's width
/// and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convention {
    /// Index of the vector's x plane; its y plane follows.
    plane: usize,
    unit: Unit,
    /// Whether positive x points left, and positive y up.
    is_left: bool,
    is_up: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Pixel,
    /// The picture's width and height.
    Side,
    /// Half the picture's width and height.
    HalfSide,
}

impl Convention {
    /// All conventions for this many vectors per pixel.
    pub(crate) fn all(vectors: usize) -> impl Iterator<Item = Self> {
        let flags = [(false, false), (false, true), (true, false), (true, true)];
        let units = [Unit::Pixel, Unit::Side, Unit::HalfSide];
        (0..vectors).map(|vector| 2 * vector).flat_map(move |plane| {
            units.into_iter().flat_map(move |unit| {
                flags.map(|(is_left, is_up)| Self { plane, unit, is_left, is_up })
            })
        })
    }

    /// Converts motion vectors to offsets.
    ///
    /// # Panics
    /// If the convention reads a second vector and `motion` has only one.
    #[must_use]
    pub fn offsets(&self, motion: &Motion) -> Offsets {
        let (width, height) = motion.size();
        let pixels = (0..motion.planes[0].len()).map(|i| self.offset(motion, i)).collect();
        Offsets { width, height, pixels }
    }

    /// The offset of pixel `i`.
    pub(crate) fn offset(&self, motion: &Motion, i: usize) -> [f32; 2] {
        let [right, down] = self.factors(motion.size());
        [motion.planes[self.plane][i] * right, motion.planes[self.plane + 1][i] * down]
    }

    /// Factors from a vector's components to pixels right and down.
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
    /// Formats it like `the second vector, x left and y down, in pixels`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_scaled_and_turned_into_offsets() {
        let planes = [0.5, -0.25, 2.0, 3.0].map(|v| vec![v; 6]).into();
        let motion = Motion::new(3, 2, planes).expect("it fits");
        let read = |plane, unit, is_left, is_up| {
            Convention { plane, unit, is_left, is_up }.offsets(&motion).pixels()[5]
        };
        assert_eq!(read(0, Unit::Side, false, false), [1.5, -0.5]);
        assert_eq!(read(0, Unit::HalfSide, true, false), [-0.75, -0.25]);
        assert_eq!(read(2, Unit::Pixel, false, true), [2.0, -3.0]);
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
