//! Frame numbers, and file names with a place for one. Nothing here touches a file.

/// Most frames that `--frames` may name.
pub(crate) const MAX_FRAMES: u64 = 1_000_000;

/// Most digits of `%0Nd`; no frame number has more than 10.
const MAX_DIGITS: usize = 32;

/// Frame numbers in ascending order, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Frames(pub(crate) Vec<u32>);

/// Reads `1-48,60,70-100x5`: frames, ranges, and ranges with a step.
///
/// # Errors
/// If the text is none of these, a range runs backwards, or there are more than [`MAX_FRAMES`].
pub(crate) fn parse(text: &str) -> Result<Frames, String> {
    let ranges = text.split(',').map(Range::parse).collect::<Result<Vec<_>, _>>()?;
    let count: u64 = ranges.iter().map(Range::count).sum();
    if count > MAX_FRAMES {
        return Err(format!("names {count} frames, and at most {MAX_FRAMES} are accepted"));
    }
    let mut frames: Vec<u32> = ranges.iter().flat_map(Range::frames).collect();
    frames.sort_unstable();
    frames.dedup();
    Ok(Frames(frames))
}

/// From the first frame up to the last, by steps.
struct Range {
    first: u32,
    last: u32,
    step: u32,
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let (ends, step) = text.split_once('x').map_or((text, "1"), |(ends, step)| (ends, step));
        let (first, last) = ends.split_once('-').unwrap_or((ends, ends));
        let number = |digits| number(digits).map_err(|why| format!("`{text}` {why}"));
        let range = Self { first: number(first)?, last: number(last)?, step: number(step)? };
        match range {
            Self { step: 0, .. } => Err(format!("`{text}` has a step of 0; give 1 or more")),
            Self { first, last, .. } if first > last => {
                Err(format!("`{text}` runs backwards; frames are denoised in ascending order"))
            }
            range => Ok(range),
        }
    }

    fn count(&self) -> u64 {
        u64::from((self.last - self.first) / self.step) + 1
    }

    fn frames(&self) -> impl Iterator<Item = u32> + use<> {
        (self.first..=self.last).step_by(self.step as usize)
    }
}

fn number(digits: &str) -> Result<u32, &'static str> {
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err("is not a frame, a range or a range with a step, such as 60, 1-48 or 70-100x5");
    }
    digits.parse().map_err(|_| "has a number above 4294967295")
}

/// Most runs of frames in one message.
const MOST_SHOWN: usize = 20;

/// Ascending frame numbers as `--frames` takes them, for a message: `1-3,7,9-10`.
pub(crate) fn shown(frames: &[u32]) -> String {
    let run = |run: &[u32]| match run {
        [only] => only.to_string(),
        _ => format!("{}-{}", run[0], run[run.len() - 1]),
    };
    let mut runs = frames.chunk_by(|&a, &b| a.checked_add(1) == Some(b));
    let first = runs.by_ref().take(MOST_SHOWN).map(run).collect::<Vec<_>>().join(",");
    match runs.map(<[u32]>::len).sum() {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// A file name with a place for the frame number: `beauty.####.exr` or `beauty.%04d.exr`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    prefix: String,
    /// Shorter numbers are padded with zeros to this many digits.
    digits: usize,
    suffix: String,
}

impl Pattern {
    /// `None` for a name without a frame number.
    ///
    /// # Errors
    /// If it has two, or asks for more digits than any number has.
    pub(crate) fn parse(name: &str) -> Result<Option<Self>, String> {
        let Some((prefix, digits, suffix)) = split(name) else { return Ok(None) };
        if split(suffix).is_some() {
            return Err("has two places for a frame number; only one is accepted".into());
        }
        if digits > MAX_DIGITS {
            return Err(format!(
                "asks for frame numbers of {digits} digits, and at most {MAX_DIGITS} are accepted"
            ));
        }
        Ok(Some(Self { prefix: prefix.into(), digits, suffix: suffix.into() }))
    }

    /// The name of a frame's file; longer numbers are not cut.
    pub(crate) fn name(&self, frame: u32) -> String {
        format!("{}{frame:0width$}{}", self.prefix, self.suffix, width = self.digits)
    }

    /// The frame for which [`name`](Self::name) returns this name.
    pub(crate) fn frame(&self, name: &str) -> Option<u32> {
        let digits = name.strip_prefix(&self.prefix)?.strip_suffix(&self.suffix)?;
        let frame = digits.parse().ok()?;
        (self.name(frame) == name).then_some(frame)
    }
}

/// The text before the first place for a frame number, its digits, and the text after it.
fn split(name: &str) -> Option<(&str, usize, &str)> {
    let hash = name.find('#').map(|at| {
        let suffix = name[at..].trim_start_matches('#');
        (&name[..at], name.len() - at - suffix.len(), suffix)
    });
    let printf = name.match_indices('%').find_map(|(at, _)| split_printf(name, at));
    [hash, printf].into_iter().flatten().min_by_key(|(prefix, ..)| prefix.len())
}

/// `%d` or `%0Nd` at a position of the name.
fn split_printf(name: &str, at: usize) -> Option<(&str, usize, &str)> {
    let (width, suffix) = name[at + 1..].split_once('d')?;
    let digits = match width.strip_prefix('0') {
        None if width.is_empty() => 1,
        Some(n) if !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()) => {
            n.parse().unwrap_or(usize::MAX)
        }
        _ => return None,
    };
    Some((&name[..at], digits, suffix))
}

#[cfg(test)]
#[path = "frames_test.rs"]
mod tests;
