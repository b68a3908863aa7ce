//! Reads the TZA container: a table of named tensors, with their values elsewhere in the file.
//!
//! All numbers are little-endian. The file begins with a 16-bit magic number, the major and the
//! minor version in one byte each, and the 64-bit offset of the table. The table is a 32-bit count
//! followed by one entry per tensor: a 16-bit length and the name, the number of dimensions in one
//! byte, a 32-bit size for each dimension, a letter for each (the layout), a letter for the value
//! type, and the 64-bit offset of the values.

use std::collections::HashSet;
use std::path::Path;

use safetensors::Dtype;

use crate::error::{Error, Result};

/// The first bytes of every file.
const MAGIC: [u8; 2] = [0xd7, 0x41];

const MAJOR_VERSION: u8 = 2;
/// The largest network has 38.
const MAX_TENSORS: u32 = 64;
const MAX_DIMENSIONS: usize = 4;
const MAX_NAME: usize = 64;

/// A tensor with its values as bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct TzaTensor<'a> {
    /// Its name, such as `enc_conv0.weight`.
    pub name: &'a str,
    /// Sizes, slowest axis first.
    pub shape: Vec<usize>,
    /// F16 or F32.
    pub dtype: Dtype,
    /// Little-endian values, row by row.
    pub data: &'a [u8],
}

/// Whether to read a weights file as TZA, judged by its extension or its first bytes. A safetensors
/// file begins with the length of its header, which may have any value, and has the header's brace
/// at byte 8.
#[must_use]
pub fn is_tza(name: &Path, bytes: &[u8]) -> bool {
    let named = name.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tza"));
    named || (bytes.starts_with(&MAGIC) && bytes.get(8) != Some(&b'{'))
}

/// All tensors, in the file's order. Their data borrow from `bytes` and together are no larger than
/// the file.
///
/// # Errors
/// Fails if the file is truncated, of another format or version, or has too many tensors, or if a
/// tensor's name, type, layout, size or offset is invalid.
pub fn read(bytes: &[u8]) -> Result<Vec<TzaTensor<'_>>> {
    let mut header = Cursor { bytes, at: 0 };
    if header.array()? != MAGIC {
        return Err(wrong(
            "the signature is missing; get the file itself, not a web page or a Git LFS \
             pointer",
        ));
    }
    let [major, minor] = header.array()?;
    if major != MAJOR_VERSION {
        return Err(wrong(&format!(
            "version {major}.{minor}, but this reads {MAJOR_VERSION}.x only"
        )));
    }
    let at = usize::try_from(u64::from_le_bytes(header.array()?)).unwrap_or(usize::MAX);
    let mut table = Cursor { bytes, at };
    let count = u32::from_le_bytes(table.array()?);
    if count > MAX_TENSORS {
        return Err(wrong(&format!("{count} tensors, expected at most {MAX_TENSORS}")));
    }
    let (mut tensors, mut names, mut total) = (Vec::new(), HashSet::new(), 0);
    for _ in 0..count {
        let tensor = table.tensor()?;
        if !names.insert(tensor.name) {
            return Err(wrong(&format!("tensor `{}` appears twice", tensor.name)));
        }
        total += tensor.data.len();
        if total > bytes.len() {
            return Err(wrong(&format!("the tensors up to `{}` overlap", tensor.name)));
        }
        tensors.push(tensor);
    }
    Ok(tensors)
}

/// A read position in the file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let taken = slice(self.bytes, self.at, count).ok_or_else(|| {
            cut_off(&format!("the file ends before the {count} bytes at {}", self.at))
        })?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        Ok(*self.take(N)?.first_chunk().expect("as many were taken"))
    }

    fn tensor(&mut self) -> Result<TzaTensor<'a>> {
        let length = u16::from_le_bytes(self.array()?);
        let name = self.take(length.into())?;
        let is_name = |b: &u8| b.is_ascii_alphanumeric() || b"_.".contains(b);
        let fits = (1..=MAX_NAME).contains(&name.len()) && name.iter().all(is_name);
        let name = std::str::from_utf8(name).ok().filter(|_| fits).ok_or_else(|| {
            wrong(&format!(
                "a tensor's name does not consist of 1 to {MAX_NAME} letters, digits, `_` and `.`"
            ))
        })?;
        let shape = self.shape(name)?;
        let [kind] = self.array()?;
        let (dtype, size) = match kind {
            b'f' => (Dtype::F32, 4),
            b'h' => (Dtype::F16, 2),
            _ => {
                return Err(wrong(&format!(
                    "tensor `{name}` has an unknown type, expected F16 or F32"
                )));
            }
        };
        let offset = usize::try_from(u64::from_le_bytes(self.array()?)).unwrap_or(usize::MAX);
        let count = shape.iter().try_fold(size, |product: usize, &n| product.checked_mul(n));
        let data = count.and_then(|count| slice(self.bytes, offset, count)).ok_or_else(|| {
            cut_off(&format!("tensor `{name}` of {shape:?} at {offset} lies outside the file"))
        })?;
        Ok(TzaTensor { name, shape, dtype, data })
    }

    /// Reads the sizes. Only the layouts of convolutions and biases are allowed.
    fn shape(&mut self, name: &str) -> Result<Vec<usize>> {
        let [dimensions] = self.array()?;
        let dimensions = usize::from(dimensions);
        if dimensions > MAX_DIMENSIONS {
            return Err(wrong(&format!(
                "tensor `{name}` has {dimensions} dimensions, expected 1 or 4"
            )));
        }
        let sizes = self.take(4 * dimensions)?;
        let size = |bytes: &[u8; 4]| u32::from_le_bytes(*bytes) as usize;
        let layout = self.take(dimensions)?;
        if ![&b"oihw"[..], b"x"].contains(&layout) {
            let layout = layout.escape_ascii();
            return Err(wrong(&format!(
                "tensor `{name}` has layout `{layout}`, expected `oihw` or `x`"
            )));
        }
        Ok(sizes.as_chunks().0.iter().map(size).collect())
    }
}

fn slice(bytes: &[u8], at: usize, count: usize) -> Option<&[u8]> {
    bytes.get(at..at.checked_add(count)?)
}

fn cut_off(what: &str) -> Error {
    Error::weights(format!("not a whole TZA file: {what}"))
}

fn wrong(what: &str) -> Error {
    Error::weights(format!("TZA file: {what}"))
}
