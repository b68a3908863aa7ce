//! The chunks of a PNG file besides its pixels, and which of them may go into the output.
//!
//! Chunks that describe colors, pixel shape or the whole picture are kept byte for byte. For the
//! others, the case of the fourth letter says whether they may be copied when pixels change (PNG,
//! third edition, 5.4 and 14.2).

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use super::density::Density;

/// A chunk besides the pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Chunk {
    pub(crate) kind: [u8; 4],
    pub(crate) data: Vec<u8>,
    /// Whether it comes after the pixels, where it must stay.
    pub(crate) after_pixels: bool,
}

/// A file's chunks that stay valid with new pixels, and the names of the others.
#[derive(Debug, Default)]
pub(crate) struct Chunks {
    list: Vec<Chunk>,
    left_out: Vec<String>,
    animated: bool,
}

/// Most bytes kept in chunks.
const MOST_BYTES: usize = 64 << 20;

/// Most names of chunks in one message.
const MOST_NAMED: usize = 8;

/// Chunks that a file has at most one of.
const SINGLE: [&[u8; 4]; 11] = [
    b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM", b"mDCV", b"cLLI", b"pHYs", b"bKGD", b"tIME",
    b"eXIf",
];

/// Chunks that mean nothing without the stored pixels; the decoder has used them.
const OF_PIXELS: [&[u8; 4]; 7] = [b"IHDR", b"PLTE", b"IDAT", b"tRNS", b"hIST", b"fcTL", b"fdAT"];

impl Chunks {
    /// Walks a PNG file. A file that ends early has the chunks up to there: the decoder tells
    /// whether the pixels are whole.
    pub(crate) fn read(mut reader: impl BufRead + Seek) -> io::Result<Self> {
        let mut chunks = Self::default();
        let (mut after_pixels, mut memory, mut has_plain_samples) = (false, 0, true);
        reader.seek(SeekFrom::Start(SIGNATURE))?;
        while let Some((len, kind)) = head(&mut reader)? {
            after_pixels |= &kind == b"IDAT";
            chunks.animated |= &kind == b"acTL";
            let is_header = &kind == b"IHDR" && len == HEADER;
            let fits = memory + len <= MOST_BYTES;
            let keeps = fits && chunks.keeps(kind, after_pixels, has_plain_samples);
            match body(&mut reader, len, kind, is_header || keeps)? {
                Some(header) if is_header => has_plain_samples = is_plain(&header),
                Some(data) => {
                    memory += len + size_of::<Chunk>();
                    chunks.list.push(Chunk { kind, data, after_pixels });
                }
                None => chunks.leave_out(kind),
            }
        }
        Ok(chunks)
    }

    /// Whether a chunk stays valid with new pixels. A background color is a sample, and samples are
    /// written with 8 or 16 bits and without a palette.
    fn keeps(&self, kind: [u8; 4], after_pixels: bool, has_plain_samples: bool) -> bool {
        if SINGLE.contains(&&kind) {
            let may_follow = matches!(&kind, b"tIME" | b"eXIf");
            return self.get(kind).is_none()
                && (!after_pixels || may_follow)
                && (&kind != b"bKGD" || has_plain_samples);
        }
        let is_ancillary = kind[0].is_ascii_lowercase();
        is_ancillary && kind[3].is_ascii_lowercase()
    }

    fn leave_out(&mut self, kind: [u8; 4]) {
        let name = String::from_utf8_lossy(&kind).into_owned();
        let silent = OF_PIXELS.contains(&&kind) || &kind == b"acTL";
        if !silent && self.left_out.len() < MOST_NAMED && !self.left_out.contains(&name) {
            self.left_out.push(name);
        }
    }

    /// The data of a chunk that a file has at most one of.
    pub(crate) fn get(&self, kind: [u8; 4]) -> Option<&[u8]> {
        self.list.iter().find(|chunk| chunk.kind == kind).map(|chunk| chunk.data.as_slice())
    }

    /// All chunks that are kept, in the file's order.
    pub(crate) fn kept(&self) -> &[Chunk] {
        &self.list
    }

    /// Whether the file has further frames.
    pub(crate) fn is_animated(&self) -> bool {
        self.animated
    }

    /// Says which chunks of this file a new PNG file lacks.
    pub(crate) fn left_out(&self) -> Option<String> {
        left_out(self.left_out.iter().map(String::as_str))
    }

    /// Says which chunks another format has no place for, besides `used`.
    pub(crate) fn lost_except(&self, used: &[&[u8; 4]]) -> Option<String> {
        let mut names: Vec<_> = Vec::new();
        for chunk in self.list.iter().filter(|chunk| !used.contains(&&chunk.kind)) {
            let name = str::from_utf8(&chunk.kind).unwrap_or_default();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        left_out(names.into_iter().chain(self.left_out.iter().map(String::as_str)))
    }

    /// The pixel density (`pHYs`).
    pub(crate) fn density(&self) -> Option<Density> {
        self.get(*b"pHYs").and_then(Density::of_png)
    }
}

fn left_out<'a>(names: impl Iterator<Item = &'a str>) -> Option<String> {
    let names: Vec<_> = names.take(MOST_NAMED).map(|name| format!("`{name}`")).collect();
    let listed = names.join(", ");
    (!names.is_empty()).then(|| format!("chunks of the PNG that were left out: {listed}"))
}

/// Length of the signature before the first chunk.
const SIGNATURE: u64 = 8;

/// Length of the header's data.
const HEADER: usize = 13;

/// Reads the length and the type of the next chunk, unless it is the last or damaged.
fn head(reader: &mut impl Read) -> io::Result<Option<(usize, [u8; 4])>> {
    let mut bytes = Vec::with_capacity(8);
    reader.by_ref().take(8).read_to_end(&mut bytes)?;
    let [a, b, c, d, kind @ ..] = bytes.as_slice() else { return Ok(None) };
    let len = u32::from_be_bytes([*a, *b, *c, *d]);
    let kind = <[u8; 4]>::try_from(kind).ok();
    let is_valid = |kind: &[u8; 4]| kind != b"IEND" && kind.iter().all(u8::is_ascii_alphabetic);
    Ok(kind
        .filter(is_valid)
        .filter(|_| i32::try_from(len).is_ok())
        .map(|kind| (len as usize, kind)))
}

/// Whether a header (11.2.1) declares samples with 8 or 16 bits and no palette.
fn is_plain(header: &[u8]) -> bool {
    matches!(header.get(8..10), Some([8 | 16, color]) if *color != 3)
}

/// Reads a chunk's data if it is wanted, whole and its checksum right; ends at the next chunk.
fn body(
    reader: &mut (impl BufRead + Seek),
    len: usize,
    kind: [u8; 4],
    is_wanted: bool,
) -> io::Result<Option<Vec<u8>>> {
    if !is_wanted {
        return reader.seek_relative(len as i64 + 4).map(|()| None);
    }
    let mut data = Vec::new();
    reader.by_ref().take(len as u64 + 4).read_to_end(&mut data)?;
    let sum = data.split_off(len.min(data.len()));
    Ok((sum == checksum(kind, &data).to_be_bytes()).then_some(data))
}

/// PNG's CRC-32 (annex D), bit by bit: chunks are small.
pub(crate) fn checksum(kind: [u8; 4], data: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), step);
    !kind.iter().chain(data).fold(u32::MAX, byte)
}
