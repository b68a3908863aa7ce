//! Gaps in sequences, which leave frames without a neighbor to be averaged with.

use std::collections::BTreeSet;
use std::path::Path;

use crate::failure::{Failure, shown};
use crate::request::Denoise;
use crate::temporal::Number;
use wgdenoise_files::inputs::Source;

/// Notices about the gaps near the frames that are `written`, if `--temporal` averages frames.
pub(crate) fn notices(
    request: &Denoise,
    sources: &[Source],
    written: &[Number],
) -> Result<Vec<String>, Failure> {
    let reach = i64::try_from(request.temporal).unwrap_or(i64::MAX);
    let mut notices = Vec::new();
    for (index, source) in sources.iter().enumerate().filter(|_| reach > 0) {
        let present: BTreeSet<_> =
            source.files(None)?.into_iter().filter_map(|(_, frame)| frame).collect();
        let near = written.iter().filter(|number| number.sequence == index).flat_map(|number| {
            number.frame.saturating_sub(reach)..=number.frame.saturating_add(reach)
        });
        let gaps = gaps(&present, near);
        if !gaps.is_empty() {
            let (frames, are) = if gaps.len() == 1 { ("frame", "is") } else { ("frames", "are") };
            notices.push(format!(
                "{}: {frames} {} {are} missing; the frames around are averaged without",
                shown(Path::new(&request.inputs[index])),
                gaps.iter().map(i64::to_string).collect::<Vec<_>>().join(", "),
            ));
        }
    }
    Ok(notices)
}

/// The numbers that are absent between those present. Sequences of every second frame or fewer have
/// no gaps.
fn gaps(present: &BTreeSet<i64>, numbers: impl Iterator<Item = i64>) -> BTreeSet<i64> {
    let (Some(&first), Some(&last)) = (present.first(), present.last()) else {
        return BTreeSet::new();
    };
    let is_spaced = !present.iter().any(|frame| present.contains(&(frame + 1)));
    let is_gap = |frame: &i64| (first..last).contains(frame) && !present.contains(frame);
    numbers.filter(|frame| !is_spaced && is_gap(frame)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_lie_between_the_frames_of_a_dense_sequence() {
        let gaps_of = |present: &[i64], numbers: std::ops::RangeInclusive<i64>| -> Vec<i64> {
            gaps(&present.iter().copied().collect(), numbers).into_iter().collect()
        };
        assert_eq!(gaps_of(&[1, 2, 4, 7], 0..=9), [3, 5, 6]);
        assert_eq!(gaps_of(&[1, 2, 4, 7], 1..=4), [3]);
        assert_eq!(gaps_of(&[1, 3, 5], 0..=9), [0_i64; 0], "every second frame");
        assert_eq!(gaps_of(&[], 0..=9), [0_i64; 0]);
    }
}
