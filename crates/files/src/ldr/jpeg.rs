//! The segments of a JPEG file besides its pixels, and whether the file is complete.

use std::io::Read;
use std::path::Path;

use super::density::Density;
use crate::Problem;
use crate::format::open;

/// A segment of metadata: its marker and its data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Segment {
    marker: u8,
    data: Vec<u8>,
}

/// A file's segments that stay valid with new pixels, and the names of the others.
#[derive(Debug, Default)]
pub(crate) struct Segments {
    list: Vec<Segment>,
    density: Option<Density>,
    has_exif: bool,
    /// Channels per pixel.
    channels: u8,
    left_out: Vec<String>,
}

/// Markers (ITU-T T.81, B.1.1): end, comment, first and last application segment.
const END: u8 = 0xd9;
const COMMENT: u8 = 0xfe;
const APP0: u8 = 0xe0;
const APP15: u8 = 0xef;

impl Segments {
    /// Walks a whole JPEG file.
    ///
    /// # Errors
    /// If the file cannot be read, has more than `most` bytes, or lacks its end marker: the decoder
    /// would fill in gray. The end marker of a thumbnail inside does not count.
    pub(crate) fn read(path: &Path, most: u64) -> Result<Self, Problem> {
        let mut bytes = Vec::new();
        open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Problem::Read)?;
        if bytes.len() as u64 > most {
            return Err(Problem::TooLarge(format!("is too large: a JPEG may have {most} bytes")));
        }
        Self::of(&bytes)
            .ok_or_else(|| Problem::Damaged("is cut off: a JPEG must have an end marker".into()))
    }

    /// Walks a file's bytes; `None` if the end is missing.
    fn of(bytes: &[u8]) -> Option<Self> {
        let mut segments = Self::default();
        let mut rest = bytes.get(2..)?;
        loop {
            match next(&mut rest)? {
                (END, _) => return Some(segments),
                (marker, data) => segments.note(marker, data),
            }
        }
    }

    /// Notes a segment. Exif data and the color profile are read elsewhere; Adobe's segment says
    /// how the pixels were stored.
    fn note(&mut self, marker: u8, data: &[u8]) {
        let starts = |name: &[u8]| data.starts_with(name);
        match marker {
            0xe0 if starts(b"JFIF\0") => {
                self.density = data.get(7..).and_then(Density::of_jfif);
            }
            // The start of a baseline, extended or progressive frame with Huffman coding (B.2.2).
            0xc0..=0xc2 => self.channels = data.get(5).copied().unwrap_or_default(),
            0xe1 if starts(b"Exif\0") => self.has_exif = true,
            0xe2 if starts(b"ICC_PROFILE\0") => {}
            0xee if starts(b"Adobe") => {}
            _ if name(marker, data).is_some() => {
                self.list.push(Segment { marker, data: data.to_vec() });
            }
            APP0..=APP15 => add(&mut self.left_out, format!("APP{}", marker - APP0)),
            _ => {}
        }
    }

    /// All segments that are kept, in the file's order.
    pub(crate) fn kept(&self) -> &[Segment] {
        &self.list
    }

    pub(crate) fn density(&self) -> Option<Density> {
        self.density
    }

    /// Whether the pixels are CMYK.
    pub(crate) fn is_cmyk(&self) -> bool {
        self.channels == 4
    }

    /// Says which segments of this file a new JPEG file lacks.
    pub(crate) fn left_out(&self) -> Option<String> {
        left_out(&self.left_out)
    }

    /// Lists the metadata that another format cannot store, with or without Exif data.
    pub(crate) fn lost(&self, with_exif: bool) -> Option<String> {
        let mut names = Vec::new();
        if with_exif && self.has_exif {
            names.push("Exif".into());
        }
        let kept = self.list.iter().filter_map(|segment| name(segment.marker, &segment.data));
        kept.for_each(|kept| add(&mut names, kept.into()));
        names.extend(self.left_out.iter().cloned());
        left_out(&names)
    }
}

/// Whether Exif data fits into a segment, after its length and name.
pub(crate) fn fits(exif: &[u8]) -> bool {
    exif.len() <= usize::from(u16::MAX) - 2 - "Exif\0\0".len()
}

/// The name of a segment that stays valid with new pixels.
fn name(marker: u8, data: &[u8]) -> Option<&'static str> {
    let starts = |name: &[u8]| data.starts_with(name);
    match marker {
        COMMENT => Some("a comment"),
        0xe1 if starts(b"http://ns.adobe.com/xap/1.0/\0") => Some("XMP"),
        0xe1 if starts(b"http://ns.adobe.com/xmp/extension/\0") => Some("XMP"),
        0xed if starts(b"Photoshop 3.0\0") => Some("IPTC"),
        _ => None,
    }
}

fn add(names: &mut Vec<String>, name: String) {
    if !names.contains(&name) {
        names.push(name);
    }
}

fn left_out(names: &[String]) -> Option<String> {
    let listed = names.join(", ");
    (!names.is_empty()).then(|| format!("metadata of the JPEG that was left out: {listed}"))
}

/// Adds segments to a JPEG file, after those that it begins with.
pub(crate) fn with_segments(bytes: &[u8], segments: &[Segment]) -> Vec<u8> {
    let mut rest = bytes.get(2..).unwrap_or_default();
    let mut at = bytes.len() - rest.len();
    while let Some((APP0..=APP15, _)) = next(&mut rest) {
        at = bytes.len() - rest.len();
    }
    let (before, after) = bytes.split_at(at);
    let mut whole = before.to_vec();
    for Segment { marker, data } in segments {
        let len = u16::try_from(data.len() + 2).expect("it was read from a segment");
        whole.extend([0xff, *marker]);
        whole.extend(len.to_be_bytes());
        whole.extend(data);
    }
    whole.extend(after);
    whole
}

/// The next marker and the data of its segment; skips pixels before it.
fn next<'a>(rest: &mut &'a [u8]) -> Option<(u8, &'a [u8])> {
    let at = rest.windows(2).position(is_marker)?;
    let marker = rest[at + 1];
    *rest = &rest[at + 2..];
    if marker == END {
        return Some((END, &[]));
    }
    let len = usize::from(u16::from_be_bytes(*rest.first_chunk()?)).max(2);
    let data = rest.get(2..len)?;
    *rest = &rest[len..];
    Some((marker, data))
}

/// Whether it is a marker, and not a stuffed 0xff, a fill byte or a restart marker, all of which
/// occur among pixels.
fn is_marker(pair: &[u8]) -> bool {
    pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_channels_are_cmyk() {
        for channels in [1, 3, 4] {
            let frame = [0xff, 0xc2, 0, 8, 8, 0, 16, 0, 16, channels];
            let file = [&[0xff, 0xd8], &frame[..], &[0xff, END]].concat();
            assert_eq!(Segments::of(&file).unwrap().is_cmyk(), channels == 4);
        }
    }

    #[test]
    fn only_the_pictures_own_end_counts() {
        let has_end = |bytes: &[u8]| Segments::of(bytes).is_some();
        let start = [0xff, 0xd8, 0xff, 0xe1, 0, 4, 0xff, 0xd9, 0xff, 0xda, 0, 2, 7, 0xff, 0, 0xff];
        assert!(!has_end(&start) && !has_end(&[0xff, 0xd8]) && !has_end(&[]));
        assert!(!has_end(&[&start[..], &[0xd0, 9]].concat()));
        assert!(has_end(&[&start[..], &[0xd0, 9, 0xff, 0xd9, 0, 0]].concat()));
    }
}
