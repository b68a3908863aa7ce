//! Finds light that changes over a whole area, as noise does not.

use rayon::prelude::*;

/// Pixels of the area on each side of its center.
const REACH: usize = 7;

/// Neighboring pixels of a denoised image whose noise is correlated.
const SPAN: f32 = 25.0;

/// Sums over an area: weights, weighted changes and weighted squared changes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Changes([f32; 3]);

impl Changes {
    /// The signed change of one pixel and its weight.
    pub(crate) fn new(change: f32, weight: f32) -> Self {
        Self([weight, weight * change, weight * change * change])
    }

    /// The squared mean change, divided by `least`² plus the variance that the mean would have if
    /// the changes were noise.
    fn significance(self, least: f32) -> f32 {
        let Self([weight, changes, squares]) = self;
        if weight <= 0.0 {
            return 0.0;
        }
        let mean = changes / weight;
        let variance = (squares / weight - mean * mean).max(0.0);
        let independent = ((2 * REACH + 1).pow(2) as f32 / SPAN).max(1.0);
        mean * mean / (least * least + variance / independent)
    }
}

/// How significant the change is in the 15×15 pixels around each pixel; see
/// [`Changes::significance`].
pub(crate) fn trend(changes: &[Changes], width: usize, least: f32) -> Vec<f32> {
    let across: Vec<Changes> = changes.par_chunks(width).flat_map_iter(sums_in_row).collect();
    let rows: Vec<_> = across.chunks(width).collect();
    let row = |y: usize| {
        let near = &rows[y.saturating_sub(REACH)..(y + REACH + 1).min(rows.len())];
        (0..width).map(move |x| sum(near.iter().map(|row| row[x])).significance(least))
    };
    (0..rows.len()).into_par_iter().flat_map_iter(row).collect()
}

fn sums_in_row(row: &[Changes]) -> impl Iterator<Item = Changes> + '_ {
    let end = |x: usize| (x + REACH + 1).min(row.len());
    (0..row.len()).map(move |x| sum(row[x.saturating_sub(REACH)..end(x)].iter().copied()))
}

fn sum(changes: impl Iterator<Item = Changes>) -> Changes {
    let add = |a: Changes, b: Changes| Changes(std::array::from_fn(|i| a.0[i] + b.0[i]));
    changes.fold(Changes::default(), add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_span_fifteen_pixels_and_end_at_the_edges() {
        let mut changes = vec![Changes::default(); 40 * 30];
        changes[20 * 40 + 30] = Changes::new(0.1, 1.0);
        for (i, found) in trend(&changes, 40, 0.1).into_iter().enumerate() {
            let (x, y) = (i % 40, i / 40);
            let is_near = x.abs_diff(30) <= 7 && y.abs_diff(20) <= 7;
            assert!((found - f32::from(u8::from(is_near))).abs() < 1e-5, "{x}, {y}: {found}");
        }
    }

    #[test]
    fn changes_count_by_their_weight_and_less_the_more_they_differ() {
        let found = |changes: &[(f32, f32)]| {
            let changes: Vec<_> = changes.iter().map(|(c, w)| Changes::new(*c, *w)).collect();
            trend(&changes, changes.len(), 0.1)[0]
        };
        assert!((found(&[(0.2, 1.0), (9.0, 0.0)]) - 4.0).abs() < 1e-4);
        assert!((found(&[(0.3, 1.0), (0.1, 3.0)]) - 0.0225 / (0.01 + 0.0075 / 9.0)).abs() < 1e-4);
        assert_eq!(found(&[(0.2, 0.0)]), 0.0);
    }
}
