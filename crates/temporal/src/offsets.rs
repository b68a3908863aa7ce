//! Where the surfaces of one frame are in another.

use rayon::prelude::*;

use crate::sample::Four;

/// For each pixel of a frame, the offset to the same surface in another frame of the same size.
#[derive(Clone, Debug, PartialEq)]
pub struct Offsets {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Pixels right and down, row by row; NaN where the surface is not visible.
    pub(crate) pixels: Vec<[f32; 2]>,
}

impl Offsets {
    /// Takes offsets in pixels, right and down, row by row; `None` if their number does not fit the
    /// size.
    #[must_use]
    pub fn new(width: u32, height: u32, pixels: Vec<[f32; 2]>) -> Option<Self> {
        (pixels.len() as u64 == u64::from(width) * u64::from(height)).then_some(Self {
            width,
            height,
            pixels,
        })
    }

    /// Zero offsets: nothing moves.
    #[must_use]
    pub fn still(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 2]; width as usize * height as usize] }
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Offsets in pixels, right and down, row by row; NaN where the surface is not visible.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 2]] {
        &self.pixels
    }

    /// Keeps offsets of at most `most` pixels; the others become NaN, as if not visible.
    #[must_use]
    pub fn up_to(mut self, most: f32) -> Self {
        for offset in &mut self.pixels {
            let length = offset[0].hypot(offset[1]);
            if length.is_nan() || length > most {
                *offset = [f32::NAN; 2];
            }
        }
        self
    }

    /// Number of pixels whose surface is not visible.
    pub(crate) fn unseen(&self) -> usize {
        self.pixels.iter().filter(|offset| offset[0].is_nan()).count()
    }

    /// Chains offsets to a third frame: `next` leads there from the frame that these offsets lead
    /// to.
    ///
    /// # Panics
    /// If the sizes differ.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        assert_eq!(self.size(), next.size(), "sizes");
        let on = |(i, own): (usize, &[f32; 2])| {
            let further = self.four(i).map_or([f32::NAN; 2], |four| four.mean(&next.pixels));
            [own[0] + further[0], own[1] + further[1]]
        };
        let pixels = self.pixels.par_iter().enumerate().map(on).collect();
        Self { pixels, ..*self }
    }

    /// The way back: each pixel of the other frame gets the negated offset that leads closest to
    /// it. NaN where no offset leads.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut pixels = vec![[f32::NAN; 2]; self.pixels.len()];
        let mut shares = vec![0.0; self.pixels.len()];
        for (i, offset) in self.pixels.iter().enumerate() {
            let around = self.four(i).into_iter().flat_map(Four::shares);
            for (at, share) in around {
                if share > shares[at] {
                    (pixels[at], shares[at]) = (offset.map(|o| -o), share);
                }
            }
        }
        Self { pixels, ..*self }
    }

    /// The pixels of the other frame around a pixel's surface; `None` outside the picture.
    pub(crate) fn four(&self, i: usize) -> Option<Four> {
        Four::around(self.end(i), self.size())
    }

    /// Where a pixel's surface is in the other frame; whole numbers are pixel centers.
    pub(crate) fn end(&self, i: usize) -> [f32; 2] {
        end(i, self.pixels[i], self.width)
    }
}

/// Where an offset from pixel `i` leads; whole numbers are pixel centers.
pub(crate) fn end(i: usize, [right, down]: [f32; 2], width: u32) -> [f32; 2] {
    let width = width as usize;
    [(i % width) as f32 + right, (i / width) as f32 + down]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(offset: [f32; 2]) -> Offsets {
        Offsets::new(6, 4, vec![offset; 24]).expect("it fits")
    }

    #[test]
    fn two_motions_add_up_while_the_surface_is_in_the_picture() {
        let found = all([2.0, 1.0]).then(&all([-0.5, 0.25]));
        for (i, offset) in found.pixels().iter().enumerate() {
            if i % 6 + 2 < 6 && i / 6 + 1 < 4 {
                assert_eq!(*offset, [1.5, 1.25], "{i}");
            } else {
                assert!(offset[0].is_nan(), "{i}: {offset:?}");
            }
        }
    }

    #[test]
    fn longer_offsets_than_wanted_lead_nowhere() {
        let offsets = [[0.6, 0.8], [0.8, 0.8], [f32::INFINITY, 0.0], [0.0, -0.5]];
        let found = Offsets::new(4, 1, offsets.into()).expect("it fits").up_to(1.0);
        assert_eq!(
            found.pixels().iter().map(|o| o[0].is_nan()).collect::<Vec<_>>(),
            [false, true, true, false]
        );
    }

    #[test]
    fn motion_leads_back_from_wherever_it_leads() {
        let found = all([2.0, -1.0]).reversed();
        for (i, offset) in found.pixels().iter().enumerate() {
            if i % 6 >= 2 && i / 6 < 3 {
                assert_eq!(*offset, [-2.0, 1.0], "{i}");
            } else {
                assert!(offset[0].is_nan() && offset[1].is_nan(), "{i}: {offset:?}");
            }
        }
        assert!(all([f32::NAN, 0.0]).reversed().pixels().iter().flatten().all(|o| o.is_nan()));
    }

    #[test]
    fn growing_surfaces_leave_no_gaps_and_of_shrinking_ones_the_closest_offset_counts() {
        let scaled = |scale: f32| {
            let pixels = (0..12u8).map(|i| [(scale - 1.0) * f32::from(i), 0.0]).collect();
            Offsets::new(12, 1, pixels).expect("it fits").reversed()
        };
        let grown = scaled(1.9);
        assert!(grown.pixels().iter().all(|offset| offset[0].is_finite()), "{grown:?}");
        // Pixels 3, 4 and 5 lead to 1.5, 2.0 and 2.5.
        assert_eq!(scaled(0.5).pixels()[2], [2.0, 0.0]);
    }

    #[test]
    fn a_wrong_number_of_offsets_is_refused() {
        assert_eq!(Offsets::new(6, 4, vec![[0.0; 2]; 23]), None);
        assert_eq!(Offsets::new(6, 4, vec![[0.0; 2]; 24]), Some(Offsets::still(6, 4)));
    }
}
