//! Packing and unpacking on all cores.

use std::thread;

use ::exr::meta::header::Header;

use crate::guard;

/// Most unpacked bytes in memory at a time, unless a single block has more.
const BATCH_BYTES: u128 = 256 << 20;

/// How many of a part's blocks to process at a time.
pub(super) fn batch(header: &Header) -> usize {
    let fitting = BATCH_BYTES / guard::block_bytes(header).max(1);
    (fitting as usize).clamp(1, 16 * workers())
}

/// How many of the leading sizes fit into memory together: at least one, at most `most`.
pub(super) fn leading(sizes: impl Iterator<Item = usize>, most: usize) -> usize {
    let sums = sizes.scan(0, |sum, size| {
        *sum += size as u128;
        Some(*sum)
    });
    sums.take(most).take_while(|&sum| sum <= BATCH_BYTES).count().max(1)
}

/// Applies `work` to every item on all cores; results keep the items' order.
pub(super) fn map<T: Send, R: Send>(items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let per_worker = items.len().div_ceil(workers()).max(1);
    let mut items = items.into_iter().peekable();
    thread::scope(|scope| {
        let mut running = Vec::new();
        while items.peek().is_some() {
            let share: Vec<T> = items.by_ref().take(per_worker).collect();
            let work = &work;
            running.push(scope.spawn(move || share.into_iter().map(work).collect::<Vec<R>>()));
        }
        let joined = running.into_iter().map(thread::ScopedJoinHandle::join);
        joined.flat_map(|result| result.expect("the work does not panic")).collect()
    })
}

fn workers() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_taken_until_they_fill_the_memory_or_are_enough() {
        let half = BATCH_BYTES as usize / 2;
        for (sizes, count) in [(vec![half; 3], 2), (vec![3 * half, 1], 1), (vec![1; 9], 4)] {
            assert_eq!(leading(sizes.into_iter(), 4), count);
        }
    }

    #[test]
    fn results_keep_the_order_of_the_items() {
        for n in [0, 1, 2, 7, 100] {
            assert_eq!(map((0..n).collect(), |i| i * i), (0..n).map(|i| i * i).collect::<Vec<_>>());
        }
    }
}
