//! Filters that model the eye, each the product of a row and a column.

use std::iter::repeat_n;

/// Weights from −radius to radius along one axis.
pub(super) struct Row(Vec<f32>);

impl Row {
    /// Samples a function at whole pixels. Scales positive values to a sum of 1, negative ones to
    /// −1.
    fn sampled(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        let radius = radius as i32;
        let weights: Vec<_> = (-radius..=radius).map(|x| weight(f64::from(x))).collect();
        let sum = |sign: f64| weights.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
        let sums = [sum(1.0), sum(-1.0).max(f64::MIN_POSITIVE)];
        let scaled = |w: &f64| w / sums[usize::from(*w <= 0.0)];
        Self(weights.iter().map(|weight| scaled(weight) as f32).collect())
    }

    /// A Gaussian with this standard deviation in pixels.
    pub(super) fn gaussian(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| bell(x, sigma))
    }

    /// The Gaussian's first derivative, which finds edges.
    pub(super) fn edge(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| -x * bell(x, sigma))
    }

    /// The Gaussian's second derivative, which finds points.
    pub(super) fn point(radius: usize, sigma: f64) -> Self {
        Self::sampled(radius, |x| ((x / sigma).powi(2) - 1.0) * bell(x, sigma))
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

fn bell(x: f64, sigma: f64) -> f64 {
    (-0.5 * (x / sigma).powi(2)).exp()
}

/// Filters a plane along its rows, repeating the edge pixels.
pub(super) fn across(plane: &[f32], width: usize, row: &Row) -> Vec<f32> {
    let mut filtered = vec![0.0; plane.len()];
    let mut extended = Vec::with_capacity(width + row.0.len());
    for (line, sums) in plane.chunks_exact(width).zip(filtered.chunks_exact_mut(width)) {
        extended.clear();
        extended.extend(repeat_n(line[0], row.radius()));
        extended.extend_from_slice(line);
        extended.extend(repeat_n(line[width - 1], row.radius()));
        // Whole lines at a time, so that the compiler uses vector instructions.
        for (shifted, weight) in extended.windows(width).zip(&row.0) {
            add(sums, shifted, *weight);
        }
    }
    filtered
}

/// The same along columns.
pub(super) fn down(plane: &[f32], width: usize, row: &Row) -> Vec<f32> {
    let last = plane.len() / width - 1;
    let mut filtered = vec![0.0; plane.len()];
    for (y, sums) in filtered.chunks_exact_mut(width).enumerate() {
        for (i, weight) in row.0.iter().enumerate() {
            let at = (y + i).saturating_sub(row.radius()).min(last);
            add(sums, &plane[at * width..][..width], *weight);
        }
    }
    filtered
}

fn add(sums: &mut [f32], line: &[f32], weight: f32) {
    sums.iter_mut().zip(line).for_each(|(sum, v)| *sum += v * weight);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_plane_stays_even_and_has_no_features() {
        let gaussian = Row::gaussian(9, 2.7);
        for (width, height) in [(1, 1), (3, 7), (40, 25)] {
            let plane = vec![0.7; width * height];
            for v in down(&across(&plane, width, &gaussian), width, &gaussian) {
                assert!((v - 0.7).abs() < 1e-6, "{v}");
            }
            for feature in [Row::edge(9, 2.7), Row::point(9, 2.7)] {
                for found in [across(&plane, width, &feature), down(&plane, width, &feature)] {
                    assert!(found.iter().all(|v| v.abs() < 1e-6));
                }
            }
        }
    }

    /// The negative weights, which sum to −1, fall on 0, and the positive ones, which sum to 1, on
    /// 1.
    #[test]
    fn a_step_is_an_edge_of_its_own_height() {
        let step: Vec<f32> = (0..41).map(|x| f32::from(u8::from(x >= 20))).collect();
        for found in [across(&step, 41, &Row::edge(9, 2.7)), down(&step, 1, &Row::edge(9, 2.7))] {
            let center = found[20].abs();
            assert!((center - 1.0).abs() < 1e-6, "{center}");
            assert_eq!((found[5], found[35]), (0.0, found[36]));
        }
    }
}
