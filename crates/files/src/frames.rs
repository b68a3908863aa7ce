//! Frame numbers, and file names with a place for one. Does not touch files.

use std::ffi::{OsStr, OsString};

/// Most frames that `--frames` may name.
pub const MAX_FRAMES: u64 = 1_000_000;

/// The largest frame number; negated, the smallest.
const MAX_FRAME: i64 = u32::MAX as i64;

/// Most digits of `%0Nd`; no frame number has more than 10.
const MAX_DIGITS: usize = 32;

/// Frame numbers in ascending order, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames(
    /// Ascending, without duplicates.
    pub Vec<i64>,
);

/// Parses a list of frames, ranges, and ranges with a step, such as `-8--1,1-48,60,70-100x5`.
///
/// # Errors
/// If the text is not such a list, a range runs backwards, or it names more than [`MAX_FRAMES`].
pub fn parse(text: &str) -> Result<Frames, String> {
    let ranges = text.split(',').map(Range::parse).collect::<Result<Vec<_>, _>>()?;
    let count: u64 = ranges.iter().map(Range::count).sum();
    if count > MAX_FRAMES {
        return Err(format!("names {count} frames, and at most {MAX_FRAMES} are accepted"));
    }
    let mut frames: Vec<i64> = ranges.iter().flat_map(Range::frames).collect();
    frames.sort_unstable();
    frames.dedup();
    Ok(Frames(frames))
}

/// Frames from the first up to the last, by steps.
struct Range {
    first: i64,
    last: i64,
    step: i64,
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let (ends, step) = text.split_once('x').map_or((text, "1"), |(ends, step)| (ends, step));
        let (first, last) = split_range(ends);
        let number = |digits| number(digits).map_err(|why| format!("`{text}` {why}"));
        let range = Self { first: number(first)?, last: number(last)?, step: number(step)? };
        match range {
            Self { step, .. } if step < 1 => {
                Err(format!("`{text}` has a step of {step}; give 1 or more"))
            }
            Self { first, last, .. } if first > last => {
                Err(format!("`{text}` runs backwards; frames are denoised in ascending order"))
            }
            range => Ok(range),
        }
    }

    fn count(&self) -> u64 {
        ((self.last - self.first) / self.step) as u64 + 1
    }

    fn frames(&self) -> impl Iterator<Item = i64> + use<> {
        (self.first..=self.last).step_by(self.step as usize)
    }
}

/// Splits a range into its ends; a dash at the start of either is its sign.
fn split_range(ends: &str) -> (&str, &str) {
    let dash = ends.get(1..).and_then(|rest| rest.find('-'));
    dash.map_or((ends, ends), |at| (&ends[..=at], &ends[at + 2..]))
}

fn number(text: &str) -> Result<i64, &'static str> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err("is not a frame, a range or a range with a step, such as 60, 1-48 or 70-100x5");
    }
    match text.parse() {
        Ok(frame) if (-MAX_FRAME..=MAX_FRAME).contains(&frame) => Ok(frame),
        _ if digits == text => Err("has a number above 4294967295"),
        _ => Err("has a number below -4294967295"),
    }
}

/// Most runs of frames in one message.
const MOST_SHOWN: usize = 20;

/// Formats ascending frame numbers for a message, as `--frames` takes them: `1-3,7,9-10`.
#[must_use]
pub fn shown(frames: &[i64]) -> String {
    let run = |run: &[i64]| match run {
        [only] => only.to_string(),
        _ => format!("{}-{}", run[0], run[run.len() - 1]),
    };
    let mut runs = frames.chunk_by(|&a, &b| a + 1 == b);
    let first = runs.by_ref().take(MOST_SHOWN).map(run).collect::<Vec<_>>().join(",");
    match runs.map(<[i64]>::len).sum() {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// A file name with a place for the frame number: `beauty.####.exr` or `beauty.%04d.exr`. In it,
/// `[#]` and `[%]` are a plain `#` and `%`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    prefix: Vec<u8>,
    place: Place,
    suffix: Vec<u8>,
}

impl Pattern {
    /// Parses a file name; `None` if it has no place for a frame number.
    ///
    /// # Errors
    /// If it has two, or asks for more digits than any number has.
    pub fn parse(name: &OsStr) -> Result<Option<Self>, String> {
        let (mut texts, mut places) = (vec![Vec::new()], Vec::new());
        for (piece, _) in pieces(name) {
            match piece {
                Piece::Byte(byte) => texts[places.len()].push(byte),
                Piece::Place(place) => {
                    places.push(place);
                    texts.push(Vec::new());
                }
            }
        }
        match (places.as_slice(), texts.as_mut_slice()) {
            ([], _) => Ok(None),
            ([Place { digits, .. }], _) if *digits > MAX_DIGITS => Err(format!(
                "asks for frame numbers of {digits} digits, and at most {MAX_DIGITS} are accepted"
            )),
            ([place], [prefix, suffix]) => {
                let [prefix, suffix] = [prefix, suffix].map(std::mem::take);
                Ok(Some(Self { prefix, place: *place, suffix }))
            }
            _ => Err(format!(
                "has two places for a frame number; only one is accepted{PLAIN_CHARACTERS}"
            )),
        }
    }

    /// The name of a frame's file; numbers longer than the place are not cut.
    #[must_use]
    pub fn name(&self, frame: i64) -> OsString {
        let number = self.place.padded(frame).into_bytes();
        to_name([&self.prefix[..], &number, &self.suffix].concat())
    }

    /// The frame that a name stands for. Both notations accept negative frames in either padding,
    /// `-0003` and `-003`.
    #[must_use]
    pub fn frame(&self, name: &OsStr) -> Option<i64> {
        let text = self.number(name)?;
        let frame = text.parse().ok()?;
        let paddings = [false, true].map(|sign_counts| Place { sign_counts, ..self.place });
        paddings.iter().any(|place| place.padded(frame) == text).then_some(frame)
    }

    /// Whether a name has another number in place of a frame's: a subframe such as `0001.25`, or
    /// one with other padding.
    #[must_use]
    pub fn is_near(&self, name: &OsStr) -> bool {
        self.number(name).is_some_and(|text| text.bytes().any(|b| b.is_ascii_digit()))
            && self.frame(name).is_none()
    }

    /// The text in place of the frame number, if it is made of digits, signs and points.
    fn number<'n>(&self, name: &'n OsStr) -> Option<&'n str> {
        let rest = name.as_encoded_bytes().strip_prefix(self.prefix.as_slice())?;
        let text = str::from_utf8(rest.strip_suffix(self.suffix.as_slice())?).ok()?;
        text.bytes().all(|b| b.is_ascii_digit() || b"+-.".contains(&b)).then_some(text)
    }
}

/// Advice on writing a name with characters that otherwise mean a frame number; it ends a sentence.
pub const PLAIN_CHARACTERS: &str = "; write [#] for a plain # and [%] for a plain %";

/// Resolves a name without a frame number: `[#]` and `[%]` become a plain `#` and `%`, and those
/// that stand alone stay.
#[must_use]
pub fn plain(name: &OsStr) -> OsString {
    let bytes = |(piece, text): (Piece, &[u8])| match piece {
        Piece::Byte(byte) => vec![byte],
        Piece::Place(_) => text.to_vec(),
    };
    to_name(pieces(name).flat_map(bytes).collect())
}

/// Whether a name is sure to have a frame number: `##` or `%04d` rather than a `#` or `%d` that may
/// mean itself.
#[must_use]
pub fn has_padded_place(name: &OsStr) -> bool {
    pieces(name).any(|(piece, _)| matches!(piece, Piece::Place(Place { digits: 2.., .. })))
}

/// Where the frame number goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    /// Shorter numbers are padded with zeros to this many digits.
    digits: usize,
    /// Whether the sign of a negative number counts as a digit, as in `printf`.
    sign_counts: bool,
}

impl Place {
    fn padded(self, frame: i64) -> String {
        let width = self.digits + usize::from(frame < 0 && !self.sign_counts);
        format!("{frame:0width$}")
    }
}

/// A piece of a name.
enum Piece {
    Byte(u8),
    Place(Place),
}

/// Splits a name into pieces, each with its text.
fn pieces(name: &OsStr) -> impl Iterator<Item = (Piece, &[u8])> {
    let mut rest = name.as_encoded_bytes();
    std::iter::from_fn(move || {
        let (piece, len) = first_piece(rest)?;
        let (text, after) = rest.split_at(len);
        rest = after;
        Some((piece, text))
    })
}

/// The first piece of a name and its length.
fn first_piece(name: &[u8]) -> Option<(Piece, usize)> {
    Some(match name {
        [] => return None,
        [b'[', byte @ (b'#' | b'%'), b']', ..] => (Piece::Byte(*byte), 3),
        [b'#', ..] => {
            let digits = name.iter().take_while(|&&byte| byte == b'#').count();
            (Piece::Place(Place { digits, sign_counts: false }), digits)
        }
        [b'%', rest @ ..] if let Some((digits, len)) = printf(rest) => {
            (Piece::Place(Place { digits, sign_counts: true }), 1 + len)
        }
        [byte, ..] => (Piece::Byte(*byte), 1),
    })
}

/// Parses `d` or `0Nd` after a `%`: the digits it asks for, and its length.
fn printf(text: &[u8]) -> Option<(usize, usize)> {
    let len = text.iter().position(|&byte| byte == b'd')?;
    match text[..len].split_first() {
        None => Some((1, 1)),
        Some((b'0', n)) if !n.is_empty() && n.iter().all(u8::is_ascii_digit) => {
            let digits = str::from_utf8(n).ok()?.parse().unwrap_or(usize::MAX);
            Some((digits, len + 1))
        }
        _ => None,
    }
}

/// Builds a file name from bytes of other names, cut at ASCII characters only.
fn to_name(bytes: Vec<u8>) -> OsString {
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(bytes);
    #[cfg(not(unix))]
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
#[path = "frames_test.rs"]
mod tests;
