//! Places the labels of a plot so that they hide neither points nor each other.

use std::ops::Range;

/// Pixels per line of text, and roughly per letter.
pub(super) const HEIGHT: i32 = 12;
const LETTER: i32 = 7;
/// Pixels from the middle of a point to its label.
const GAP: i32 = 9;

type Place = (i32, i32);

/// A rectangle from its top left corner to its bottom right corner.
#[derive(Clone, Copy, Debug)]
struct Area(Place, Place);

impl Area {
    fn of(text: &str, (x, y): Place) -> Self {
        Self((x, y), (x + LETTER * text.chars().count() as i32, y + HEIGHT))
    }

    fn meets(&self, other: &Self) -> bool {
        let Self((x0, y0), (x1, y1)) = *self;
        let Self((u0, v0), (u1, v1)) = *other;
        x0 < u1 && u0 < x1 && y0 < v1 && v0 < y1
    }
}

/// Places every text next to its point, within the frame, where it overlaps the fewest points and
/// earlier texts. Returns the texts with their top left corners.
pub(super) fn placed(
    named: &[(Place, String)],
    points: &[Place],
    (across, down): &(Range<i32>, Range<i32>),
) -> Vec<(String, Place)> {
    let point = |&(x, y): &Place| Area((x - GAP / 2, y - GAP / 2), (x + GAP / 2, y + GAP / 2));
    let mut taken: Vec<Area> = points.iter().map(point).collect();
    let mut placed = Vec::new();
    for (at, text) in named {
        let cost = |corner: &Place| {
            let area = Area::of(text, *corner);
            let Area((left, top), (right, bottom)) = area;
            let inside = across.contains(&left) && across.contains(&right);
            let outside = !(inside && down.contains(&top) && down.contains(&bottom));
            (outside, taken.iter().filter(|other| area.meets(other)).count())
        };
        let corner = corners(text, *at).into_iter().min_by_key(cost).unwrap_or(*at);
        taken.push(Area::of(text, corner));
        placed.push((text.clone(), corner));
    }
    placed
}

/// Candidate positions, preferred first: no other point can be below and to the left of a point on
/// the front, since it would be faster and closer.
fn corners(text: &str, (x, y): Place) -> [Place; 8] {
    let width = LETTER * text.chars().count() as i32;
    let (right, middle, left) = (x + GAP, x - width / 2, x - GAP - width);
    let (below, beside, above) = (y + GAP, y - HEIGHT / 2, y - GAP - HEIGHT);
    [
        (left, below),
        (middle, below),
        (left, beside),
        (right, beside),
        (middle, above),
        (right, above),
        (right, below),
        (left, above),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_close_points_meet_neither_points_nor_each_other() {
        let points = [(100, 100), (112, 100), (100, 112), (106, 94)];
        let named: Vec<_> = points.iter().map(|&p| (p, "high f32".to_string())).collect();
        let placed = placed(&named, &points, &(0..300, 0..300));
        let areas: Vec<_> = placed.iter().map(|(text, at)| Area::of(text, *at)).collect();
        for (i, area) in areas.iter().enumerate() {
            assert!(areas[..i].iter().all(|other| !area.meets(other)), "{placed:?}");
            let dot = |&(x, y): &Place| Area((x - 3, y - 3), (x + 3, y + 3));
            assert!(points.iter().all(|p| !area.meets(&dot(p))), "{placed:?}");
        }
    }

    #[test]
    fn a_text_stays_in_the_frame() {
        let corner = |at: Place| placed(&[(at, "balanced".into())], &[at], &(0..100, 0..100))[0].1;
        assert_eq!(corner((5, 95)), (5 + GAP, 95 - GAP - HEIGHT));
        assert_eq!(corner((95, 50)), (95 - GAP - 8 * LETTER, 50 + GAP));
    }
}
