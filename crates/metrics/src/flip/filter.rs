//! What the eye lets through: filters that are products of a row and a column.

/// Weights from −radius to radius along one axis.
pub(super) struct Row(Vec<f64>);

impl Row {
    /// A function sampled at whole pixels.
    fn sampled(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        let radius = radius as i32;
        Self((-radius..=radius).map(|x| weight(f64::from(x))).collect())
    }

    /// Scales the positive weights to a sum of 1 and the negative ones to −1.
    fn balanced(mut self) -> Self {
        let sum = |sign: f64| self.0.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
        let sums = [sum(1.0), sum(-1.0)];
        for weight in &mut self.0 {
            *weight /= if *weight > 0.0 { sums[0] } else { sums[1].max(f64::MIN_POSITIVE) };
        }
        self
    }

    /// A Gaussian with this standard deviation in pixels.
    pub(super) fn gaussian(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| bell(x, sigma)).balanced()
    }

    /// Its first derivative, which finds edges.
    pub(super) fn edge(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| -x * bell(x, sigma)).balanced()
    }

    /// Its second derivative, which finds points.
    pub(super) fn point(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| ((x / sigma).powi(2) - 1.0) * bell(x, sigma)).balanced()
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

fn bell(x: f64, sigma: f64) -> f64 {
    (-0.5 * (x / sigma).powi(2)).exp()
}

/// The sum of a plane around each pixel, by `across` along rows and `down` along columns. Beyond the
/// border, the nearest pixel counts.
pub(super) fn filtered(plane: &[f64], width: usize, across: &Row, down: &Row) -> Vec<f64> {
    let height = plane.len() / width;
    let mut rows = vec![0.0; plane.len()];
    for (row, sums) in plane.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        for (x, sum) in sums.iter_mut().enumerate() {
            *sum = weighted(across, x, width).map(|(at, weight)| row[at] * weight).sum();
        }
    }
    let mut both = vec![0.0; plane.len()];
    for (y, sums) in both.chunks_exact_mut(width).enumerate() {
        for (at, weight) in weighted(down, y, height) {
            let row = &rows[at * width..][..width];
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * weight);
        }
    }
    both
}

/// The positions that a row reaches from `center`, with their weights.
fn weighted(row: &Row, center: usize, side: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let radius = row.radius();
    let at = move |i: usize| (center + i).saturating_sub(radius).min(side - 1);
    row.0.iter().enumerate().map(move |(i, weight)| (at(i), *weight))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_plane_stays_even_and_has_no_features() {
        let gaussian = Row::gaussian(9, 2.7);
        for (width, height) in [(1, 1), (3, 7), (40, 25)] {
            let plane = vec![0.7; width * height];
            for v in filtered(&plane, width, &gaussian, &gaussian) {
                assert!((v - 0.7).abs() < 1e-12, "{v}");
            }
            for feature in [Row::edge(9, 2.7), Row::point(9, 2.7)] {
                let found = filtered(&plane, width, &feature, &gaussian);
                assert!(found.iter().all(|v| v.abs() < 1e-12));
            }
        }
    }

    /// The weights of a step's dark side, −1, meet 0, and those of its bright side, 1, meet 1.
    #[test]
    fn a_step_is_an_edge_of_its_own_height() {
        let step: Vec<f64> = (0..41).map(|x| f64::from(u8::from(x >= 20))).collect();
        let found = filtered(&step, 41, &Row::edge(9, 2.7), &Row::gaussian(9, 2.7));
        let center = found[20].abs();
        assert!((center - 1.0).abs() < 1e-12, "{center}");
        assert_eq!((found[5], found[35]), (0.0, found[36]));
    }
}
