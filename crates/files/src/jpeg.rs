//! Telling whether a JPEG file is complete.

use std::io::Read;
use std::path::Path;

use super::Problem;
use super::format::open;

/// Whether the image has its end marker. That of a thumbnail inside does not count, nor does data
/// after the end.
///
/// # Errors
/// If the file cannot be read or has more than `most` bytes.
pub(super) fn is_whole(path: &Path, most: u64) -> Result<bool, Problem> {
    let mut bytes = Vec::new();
    open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Problem::Read)?;
    if bytes.len() as u64 > most {
        return Err(Problem::TooLarge(format!("is too large: a JPEG may have {most} bytes")));
    }
    Ok(has_end(&bytes))
}

/// Goes from marker to marker (ITU T.81, B.1.1), past the pixels between them.
fn has_end(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(2..).unwrap_or_default();
    while let Some(at) = rest.windows(2).position(is_marker) {
        if rest[at + 1] == 0xd9 {
            return true;
        }
        let segment = &rest[at + 2..];
        let len = segment.first_chunk().map_or(usize::MAX, |&len| u16::from_be_bytes(len).into());
        rest = segment.get(len..).unwrap_or_default();
    }
    false
}

/// Not a stuffed 0xff, a fill byte or a restart marker, all of which occur among pixels.
fn is_marker(pair: &[u8]) -> bool {
    pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_pictures_own_end_counts() {
        let start = [0xff, 0xd8, 0xff, 0xe1, 0, 4, 0xff, 0xd9, 0xff, 0xda, 0, 2, 7, 0xff, 0, 0xff];
        assert!(!has_end(&start) && !has_end(&[0xff, 0xd8]) && !has_end(&[]));
        assert!(!has_end(&[&start[..], &[0xd0, 9]].concat()));
        assert!(has_end(&[&start[..], &[0xd0, 9, 0xff, 0xd9, 0, 0]].concat()));
    }
}
