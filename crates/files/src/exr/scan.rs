//! A first pass over a header: finds its end and checks that it parses in little memory.

use std::io::{BufRead, Read, Seek};

use ::exr::meta::attribute::{AttributeValue, ChannelDescription, Text};
use ::exr::meta::header::Header;

use super::Problem;
use crate::escape::escaped;

/// Most memory that a parsed header may take; those of large scenes hold some MiB of cryptomatte
/// names.
const MAX_MEMORY: u64 = 128 << 20;

/// The longest name of an attribute or a type.
const MAX_NAME: u64 = 255;

/// The flag of multi-part files.
const MULTI_PART: u32 = 0x1000;

/// Finds where the header of a file of `len` bytes ends.
///
/// # Errors
/// If the file ends before that, or the header cannot be parsed within its memory.
pub(super) fn scan(reader: impl BufRead + Seek, len: u64) -> Result<u64, Problem> {
    let mut scan = Scan { reader, len, position: 0, part: 0, last: String::new(), memory: 0 };
    scan.number()?;
    let several_parts = scan.number()? & MULTI_PART != 0;
    while scan.part()? && several_parts {
        scan.part += 1;
    }
    Ok(scan.position)
}

struct Scan<R> {
    reader: R,
    len: u64,
    position: u64,
    /// The current part.
    part: usize,
    /// The current attribute, escaped.
    last: String,
    memory: u64,
}

impl<R: BufRead + Seek> Scan<R> {
    /// Skips a part; returns false if there is none, which ends a list of parts.
    fn part(&mut self) -> Result<bool, Problem> {
        let mut attributes = 0;
        while self.attribute()? {
            attributes += 1;
        }
        self.take_memory(2 * size_of::<Header>() as u64)?;
        Ok(attributes > 0)
    }

    /// Skips an attribute; returns false if there is none, which ends the part.
    fn attribute(&mut self) -> Result<bool, Problem> {
        let name = self.text()?;
        if name.is_empty() {
            return Ok(false);
        }
        self.last = escaped(&String::from_utf8_lossy(&name));
        let kind = self.text()?;
        let size = self.number()?;
        if size > i32::MAX as u32 {
            return Err(Problem::Damaged(format!(
                "has a damaged header: the attribute `{}` has a negative size",
                self.last
            )));
        }
        let left = self.len.saturating_sub(self.position);
        if u64::from(size) > left {
            return Err(self.cut_off(&format!(", which has {size} bytes, and {left} are present")));
        }
        self.take_memory(parsed(&kind, size.into()))?;
        self.reader.seek_relative(size.into()).map_err(Problem::Read)?;
        self.position += u64::from(size);
        Ok(true)
    }

    /// Reads a name up to the zero that ends it.
    fn text(&mut self) -> Result<Vec<u8>, Problem> {
        let mut text = Vec::new();
        let mut limited = self.reader.by_ref().take(MAX_NAME + 1);
        self.position += limited.read_until(0, &mut text).map_err(Problem::Read)? as u64;
        match text.pop() {
            Some(0) => Ok(text),
            Some(_) if text.len() as u64 == MAX_NAME => Err(Problem::Damaged(format!(
                "has a damaged header: the name after the attribute `{}` has no end",
                self.last
            ))),
            _ => Err(self.cut_off("")),
        }
    }

    fn number(&mut self) -> Result<u32, Problem> {
        let mut bytes = [0; 4];
        if self.len.saturating_sub(self.position) < 4 {
            return Err(self.cut_off(""));
        }
        self.reader.read_exact(&mut bytes).map_err(Problem::Read)?;
        self.position += 4;
        Ok(u32::from_le_bytes(bytes))
    }

    fn take_memory(&mut self, bytes: u64) -> Result<(), Problem> {
        self.memory += bytes;
        if self.memory <= MAX_MEMORY {
            return Ok(());
        }
        Err(Problem::TooLarge(format!(
            "has a header that would take over {} MiB of memory by its part {}, and no more is \
             accepted",
            MAX_MEMORY >> 20,
            self.part
        )))
    }

    fn cut_off(&self, what: &str) -> Problem {
        Problem::Damaged(match self.last.as_str() {
            "" => format!("is cut off: its header has no more than {} bytes", self.len),
            last => format!(
                "is cut off within the header of its part {}, at the attribute `{last}`{what}",
                self.part
            ),
        })
    }
}

/// The memory that a parsed attribute takes: its slot in a table, which may be half empty, its
/// bytes while they are read and kept, and the items of lists.
fn parsed(kind: &[u8], size: u64) -> u64 {
    let place = 2 * size_of::<(Text, AttributeValue)>() as u64;
    // A channel has at least 18 bytes, a text in a list at least 4.
    let taken_apart = match kind {
        b"chlist" => 2 * size / 18 * size_of::<ChannelDescription>() as u64,
        b"stringvector" => 2 * size / 4 * size_of::<Text>() as u64,
        _ => 0,
    };
    place + 2 * size + taken_apart
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn attribute(name: &str, kind: &str, size: usize) -> Vec<u8> {
        let head = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat();
        [head, (size as u32).to_le_bytes().to_vec(), vec![7; size]].concat()
    }

    fn file(flags: u32, rest: &[u8]) -> Vec<u8> {
        [&[0x76, 0x2f, 0x31, 0x01][..], &(2 | flags).to_le_bytes(), rest].concat()
    }

    fn scanned(file: &[u8]) -> Result<u64, String> {
        scan(Cursor::new(file), file.len() as u64).map_err(|problem| problem.to_string())
    }

    #[test]
    fn the_end_is_behind_the_only_part_or_the_last_of_several() {
        let part = [attribute("a", "int", 4), attribute("b", "x", 0), vec![0]].concat();
        assert_eq!(scanned(&file(0, &[&part[..], &[0; 9]].concat())), Ok(8 + part.len() as u64));
        let parts = [&part[..], &part, &[0; 9]].concat();
        assert_eq!(scanned(&file(MULTI_PART, &parts)), Ok(9 + 2 * part.len() as u64));
    }

    #[test]
    fn a_header_that_ends_too_early_is_refused_wherever_it_ends() {
        let part = [attribute("a", "int", 4), attribute("channels", "chlist", 20)].concat();
        let whole = file(0, &[&part[..], &[0]].concat());
        for len in 0..whole.len() {
            let error = scanned(&whole[..len]).unwrap_err();
            assert!(error.starts_with("is cut off"), "{len}: {error}");
        }
        let error = scanned(&whole[..whole.len() - 6]).unwrap_err();
        let expected = "is cut off within the header of its part 0, at the attribute `channels`, \
                        which has 20 bytes, and 15 are present";
        assert_eq!(error, expected);
    }

    #[test]
    fn names_without_an_end_and_negative_sizes_are_damage() {
        let endless = [attribute("a", "int", 4), vec![b'x'; 300]].concat();
        let error = scanned(&file(0, &endless)).unwrap_err();
        assert!(error.contains("after the attribute `a` has no end"), "{error}");
        let negative = [&b"a\0int\0"[..], &[0xff; 4]].concat();
        let error = scanned(&file(0, &negative)).unwrap_err();
        assert!(error.contains("`a` has a negative size"), "{error}");
    }

    /// Each of these would take over a hundred MiB once parsed.
    #[test]
    fn headers_that_grow_when_they_are_parsed_are_refused() {
        for part in [
            attribute("preview", "preview", 80 << 20),
            attribute("multiView", "stringvector", 16 << 20),
            attribute("channels", "chlist", 32 << 20),
            attribute("a", "b", 0).repeat(1 << 20),
            [attribute("a", "b", 0), vec![0]].concat().repeat(1 << 18),
        ] {
            let error = scanned(&file(MULTI_PART, &part)).unwrap_err();
            assert!(error.contains("over 128 MiB of memory"), "{error}");
        }
        assert!(scanned(&file(0, &[attribute("m", "string", 40 << 20), vec![0]].concat())).is_ok());
    }
}
