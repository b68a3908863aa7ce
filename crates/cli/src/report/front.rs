//! The Pareto front: which configurations are worth their time.

use super::measure::Row;

/// Marks the rows than which no other is at least as fast and as close to the reference, and in
/// one of the two better.
pub(super) fn mark(rows: &mut [Row]) {
    let points: Vec<_> = rows.iter().map(point).collect();
    for (row, own) in rows.iter_mut().zip(&points) {
        let Some(own) = own else { continue };
        row.front = !points.iter().flatten().any(|other| beats(*other, *own));
    }
}

/// Time and error of what was measured.
fn point(row: &Row) -> Option<(f64, f64)> {
    row.measured().map(|measured| (measured.median(), measured.metrics.l1))
}

fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    a.0 <= b.0 && a.1 <= b.1 && a != b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_slower_and_no_better_or_worse_and_no_faster_is_not_on_the_front() {
        let mut rows = [
            Row::made_up(Ok((2.0, 0.5))),
            Row::made_up(Ok((1.0, 0.9))),
            Row::made_up(Err("failed")),
            Row::made_up(Ok((3.0, 0.5))),
            Row::made_up(Ok((1.0, 0.95))),
            Row::made_up(Ok((2.5, 0.7))),
            Row::made_up(Ok((9.0, 0.4))),
            Row::made_up(Ok((9.0, 0.4))),
        ];
        mark(&mut rows);
        let front = rows.map(|row| row.front);
        assert_eq!(front, [true, true, false, false, false, false, true, true]);
    }
}
