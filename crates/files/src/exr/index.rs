//! The positions of an EXR file's blocks.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;

use ::exr::block::chunk::TileCoordinates;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;

use crate::error::Problem;
use crate::guard;

/// One stored block: some scan lines or a tile of one part.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Index of its part.
    pub(super) part: usize,
    /// Index in the offset table, which covers all parts.
    pub(super) slot: usize,
    /// Position of its head in the file.
    pub(super) offset: u64,
    /// Length of the head: part number, position and size.
    pub(super) head: usize,
    /// Length of the packed pixels that follow the head.
    pub(super) stored: usize,
    /// Which tile, or which run of scan lines, and of which level.
    pub(super) tile: TileCoordinates,
}

impl Block {
    /// Position of the end of its packed pixels in the file.
    fn end(&self) -> u64 {
        self.offset + (self.head + self.stored) as u64
    }
}

/// Finds every block, ordered by position in the file.
///
/// The table's length must have been checked against the file's.
///
/// # Errors
/// If a block is missing, its head contradicts the header, it is too long for its pixels, or two
/// blocks share bytes: a small file could otherwise expand to any size.
pub(super) fn read(
    file: &File,
    meta: &MetaData,
    header_end: u64,
    file_len: u64,
) -> Result<Vec<Block>, Problem> {
    let mut reader = BufReader::new(file);
    reader.seek(SeekFrom::Start(header_end)).map_err(Problem::Read)?;
    let total: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let table_end = header_end + 8 * total as u64;
    let mut places = read_table(&mut reader, meta, table_end..file_len)?;
    places.sort_unstable_by_key(|&(offset, ..)| offset);

    let mut blocks = Vec::with_capacity(places.len());
    let mut position = table_end;
    for &(offset, slot, part) in &places {
        if blocks.last().is_some_and(|b: &Block| offset < b.end()) {
            return Err(Problem::Damaged(format!(
                "is damaged: two blocks overlap at byte {offset}"
            )));
        }
        // No file is longer than i64::MAX, so both positions fit.
        reader.seek_relative(offset as i64 - position as i64).map_err(Problem::Read)?;
        let head = Head::read(&mut reader, meta, part);
        position = reader.stream_position().map_err(Problem::Read)?;
        if let Some(head) = head.filter(|h| position + h.stored as u64 <= file_len) {
            blocks.push(head.block(&meta.headers[part], part, slot, offset)?);
        }
    }
    match total - blocks.len() {
        0 => Ok(blocks),
        missing => Err(are_missing(&missing.to_string(), total)),
    }
}

fn are_missing(count: &str, total: usize) -> Problem {
    Problem::Damaged(format!("is cut off or incomplete: {count} of {total} blocks are missing"))
}

/// Reads every offset that lies within the file, with its slot and part. A table of zeros takes no
/// memory and little time.
fn read_table(
    reader: &mut impl Read,
    meta: &MetaData,
    within: Range<u64>,
) -> Result<Vec<(u64, usize, usize)>, Problem> {
    let counts = meta.headers.iter().enumerate();
    let parts = counts.flat_map(|(part, header)| (0..header.chunk_count).map(move |_| part));
    let (mut places, mut bytes) = (Vec::new(), [0; 8]);
    for (slot, part) in parts.enumerate() {
        reader.read_exact(&mut bytes).map_err(Problem::Read)?;
        let offset = u64::from_le_bytes(bytes);
        if within.contains(&offset) {
            places.push((offset, slot, part));
        } else if slot - places.len() > MOST_MISSING {
            let total = meta.headers.iter().map(|header| header.chunk_count).sum();
            return Err(are_missing(&format!("over {MOST_MISSING}"), total));
        }
    }
    Ok(places)
}

/// Most missing blocks that are counted.
const MOST_MISSING: usize = 10_000_000;

/// Bytes that a block may have beyond twice its pixels, although it should never exceed them once.
const SLACK: u128 = 1 << 16;

/// The fields before a block's packed pixels.
struct Head {
    part: i32,
    position: Vec<i32>,
    stored: usize,
    len: usize,
}

impl Head {
    /// Reads a head; `None` if the file ends within it or the size is negative.
    fn read(reader: &mut impl Read, meta: &MetaData, expected_part: usize) -> Option<Self> {
        let named = usize::from(meta.requirements.is_multilayer());
        let tiled = meta.headers[expected_part].blocks.has_tiles();
        let count = named + if tiled { 5 } else { 2 };
        let mut values = Vec::with_capacity(count);
        for _ in 0..count {
            let mut bytes = [0; 4];
            reader.read_exact(&mut bytes).ok()?;
            values.push(i32::from_le_bytes(bytes));
        }
        let stored = usize::try_from(values.pop()?).ok()?;
        let part = if named == 1 { values.remove(0) } else { expected_part as i32 };
        Some(Self { part, position: values, stored, len: 4 * count })
    }

    fn block(
        &self,
        header: &Header,
        part: usize,
        slot: usize,
        offset: u64,
    ) -> Result<Block, Problem> {
        let wrong = || {
            Problem::Damaged(format!(
                "is damaged: the block at byte {offset} is not where its head says"
            ))
        };
        let tile = self.tile(header).filter(|_| self.part == part as i32).ok_or_else(wrong)?;
        if self.stored as u128 > 2 * guard::block_bytes(header) + SLACK {
            return Err(Problem::Damaged(format!(
                "is damaged: the block at byte {offset} has {} bytes, more than its pixels",
                self.stored
            )));
        }
        Ok(Block { part, slot, offset, head: self.len, stored: self.stored, tile })
    }

    fn tile(&self, header: &Header) -> Option<TileCoordinates> {
        let of = |value: i32| usize::try_from(value).ok();
        Some(match *self.position.as_slice() {
            [x, y, level_x, level_y] => TileCoordinates {
                tile_index: Vec2(of(x)?, of(y)?),
                level_index: Vec2(of(level_x)?, of(level_y)?),
            },
            [y] => {
                let line = of(y.checked_sub(header.own_attributes.layer_position.y())?)?;
                let run = line / header.compression.scan_lines_per_block();
                TileCoordinates { tile_index: Vec2(0, run), level_index: Vec2(0, 0) }
            }
            _ => return None,
        })
    }
}
