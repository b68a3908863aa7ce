//! The Gaussian window over which SSIM and BRISQUE take local means.

/// A square window with Gaussian weights, which sum to 1 even where the border clips it.
pub(super) struct Gaussian {
    /// Pixels on each side of the center.
    pub(super) radius: usize,
    /// Standard deviation, in pixels.
    pub(super) sigma: f64,
}

impl Gaussian {
    /// The weighted mean around each pixel: first along the rows, then along the columns.
    pub(super) fn blurred(&self, plane: &[f64], width: usize) -> Vec<f64> {
        let across = blurred_rows(plane, width, &self.slices(width));
        let mut both = vec![0.0; plane.len()];
        let rows = self.slices(plane.len() / width);
        for (sums, slice) in both.chunks_exact_mut(width).zip(&rows) {
            let seen = across[slice.start * width..].chunks_exact(width).zip(&slice.weights);
            for (row, weight) in seen {
                sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * weight);
            }
        }
        both
    }

    /// The window's slice at each position along a side.
    fn slices(&self, side: usize) -> Vec<Slice> {
        let slice = |center: usize| {
            let start = center.saturating_sub(self.radius);
            let end = side.min(center + self.radius + 1);
            let gaussian =
                |i: usize| (-0.5 * (i.abs_diff(center) as f64 / self.sigma).powi(2)).exp();
            let sum: f64 = (start..end).map(gaussian).sum();
            Slice { start, weights: (start..end).map(|i| gaussian(i) / sum).collect() }
        };
        (0..side).map(slice).collect()
    }
}

/// The window along one axis.
struct Slice {
    start: usize,
    /// Weights of the positions from `start` on.
    weights: Vec<f64>,
}

fn blurred_rows(plane: &[f64], width: usize, columns: &[Slice]) -> Vec<f64> {
    let mut across = Vec::with_capacity(plane.len());
    for row in plane.chunks_exact(width) {
        let seen = |slice: &Slice| {
            let pairs = row[slice.start..].iter().zip(&slice.weights);
            pairs.map(|(v, weight)| v * weight).sum::<f64>()
        };
        across.extend(columns.iter().map(seen));
    }
    across
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Gaussian = Gaussian { radius: 5, sigma: 1.5 };

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn an_impulse_blurs_to_the_gaussian_along_its_own_axes() {
        let mut plane = vec![0.0; 17 * 16];
        plane[7 * 17 + 8] = 1.0;
        let found = WINDOW.blurred(&plane, 17);
        let sum: f64 = (-5..=5).map(|i| (-f64::from(i * i) / 4.5).exp()).sum();
        for (x, y, distance_squared) in [(8, 7, 0.0), (10, 7, 4.0), (8, 10, 9.0), (11, 5, 13.0)] {
            assert_near(found[y * 17 + x], (-distance_squared / 4.5_f64).exp() / (sum * sum));
        }
        assert_near(found[7 * 17 + 14], 0.0);
    }

    #[test]
    fn an_even_plane_stays_even_up_to_its_border() {
        for (width, height) in [(1, 1), (3, 20), (12, 4)] {
            for value in WINDOW.blurred(&vec![0.7; width * height], width) {
                assert_near(value, 0.7);
            }
        }
    }
}
