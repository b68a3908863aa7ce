//! Bilinear sampling of images.

/// The four pixels around a point, with edges repeated, and their bilinear weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four {
    at: [usize; 4],
    shares: [f32; 4],
}

impl Four {
    /// Finds the pixels around the point `x`, `y`, where whole numbers are pixel centers. `None`
    /// beyond the image's border, half a pixel outside the outermost centers, and for NaN.
    pub(crate) fn around([x, y]: [f32; 2], (width, height): (u32, u32)) -> Option<Self> {
        let is_inside = |at: f32, side: u32| at >= -0.5 && at <= side as f32 - 0.5;
        if !is_inside(x, width) || !is_inside(y, height) {
            return None;
        }
        let (columns, right) = axis(x, width as usize);
        let (rows, down) = axis(y, height as usize);
        let at = |row: usize, column: usize| rows[row] * width as usize + columns[column];
        Some(Self {
            at: [at(0, 0), at(0, 1), at(1, 0), at(1, 1)],
            shares: [
                (1.0 - right) * (1.0 - down),
                right * (1.0 - down),
                (1.0 - right) * down,
                right * down,
            ],
        })
    }

    /// The pixels and their weights.
    pub(crate) fn shares(self) -> impl Iterator<Item = (usize, f32)> {
        self.at.into_iter().zip(self.shares)
    }

    /// The bilinear mean of per-pixel values. A pixel of weight 0 does not count, even if it is
    /// NaN.
    pub(crate) fn mean<const N: usize>(&self, pixels: &[[f32; N]]) -> [f32; N] {
        self.mean_of(self.at.map(|at| pixels[at]))
    }

    /// The bilinear mean of the four pixels' values, row by row.
    pub(crate) fn mean_of<const N: usize>(&self, values: [[f32; N]; 4]) -> [f32; N] {
        let mut sum = [0.0; N];
        let shares = values.iter().zip(self.shares).filter(|(_, share)| *share != 0.0);
        for (value, share) in shares {
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += value * share;
            }
        }
        sum
    }
}

/// The two nearest centers along an axis, and the weight of the second.
fn axis(at: f32, side: usize) -> ([usize; 2], f32) {
    let first = at.floor();
    let clamped = |index: f32| (index.max(0.0) as usize).min(side - 1);
    ([clamped(first), clamped(first + 1.0)], at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Vec<[f32; 2]> {
        (0..12u8).map(|i| [f32::from(i % 4), f32::from(i / 4)]).collect()
    }

    #[test]
    fn between_pixels_a_ramp_goes_on_and_at_the_border_it_stays() {
        let at = |x, y| Four::around([x, y], (4, 3)).map(|four| four.mean(&ramp()));
        assert_eq!(at(1.25, 0.5), Some([1.25, 0.5]));
        assert_eq!(at(3.0, 2.0), Some([3.0, 2.0]));
        assert_eq!(at(-0.5, 2.5), Some([0.0, 2.0]));
        for outside in [(-0.6, 1.0), (3.6, 1.0), (1.0, 2.6), (f32::NAN, 1.0)] {
            assert_eq!(at(outside.0, outside.1), None, "{outside:?}");
        }
    }
}
