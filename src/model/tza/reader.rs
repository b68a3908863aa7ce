//! The container: named tensors in a table, and their values elsewhere in the file.
//!
//! Little-endian. The file begins with a 16-bit magic number, the major and the minor version in
//! a byte each, and the 64-bit offset of the table. The table is a 32-bit count and, for each
//! tensor, its name after a 16-bit length, the number of dimensions in a byte, a 32-bit size for
//! each, a letter for each (the layout), a letter for the type of the values, and their 64-bit
//! offset.

use std::collections::HashSet;
use std::path::Path;

use safetensors::Dtype;

use crate::error::{Error, Result};

/// How every file begins.
const MAGIC: [u8; 2] = [0xd7, 0x41];

const MAJOR_VERSION: u8 = 2;
/// The largest network has 38.
const MAX_TENSORS: u32 = 64;
const MAX_DIMENSIONS: usize = 4;
const MAX_NAME: usize = 64;

/// A tensor, its values still bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct TzaTensor<'a> {
    /// Such as `enc_conv0.weight`.
    pub name: &'a str,
    /// Sizes, slowest axis first.
    pub shape: Vec<usize>,
    /// F16 or F32.
    pub dtype: Dtype,
    /// Little-endian values, row by row.
    pub data: &'a [u8],
}

/// Whether a weights file is read as TZA: by its name or else by how it begins. A safetensors file
/// begins with the length of its header, which may be any, and has the header's brace at byte 8.
#[must_use]
pub fn is_tza(name: &Path, bytes: &[u8]) -> bool {
    let named = name.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tza"));
    named || (bytes.starts_with(&MAGIC) && bytes.get(8) != Some(&b'{'))
}

/// All tensors, in the file's order. Their data are views of `bytes` that do not exceed the file
/// in total.
///
/// # Errors
/// If the file is cut off, of another format or version, or has too many tensors, or one's name,
/// type, layout, size or place is not what it can be.
pub fn read(bytes: &[u8]) -> Result<Vec<TzaTensor<'_>>> {
    let mut header = Cursor { bytes, at: 0 };
    if header.array()? != MAGIC {
        return Err(wrong(
            "the file does not begin as such files do; get the file itself, not a web page or a \
             Git LFS pointer in its place",
        ));
    }
    let [major, minor] = header.array()?;
    if major != MAJOR_VERSION {
        return Err(wrong(&format!("version {major}.{minor}, but this reads {MAJOR_VERSION}.x")));
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
            return Err(wrong(&format!("tensor `{}` is there twice", tensor.name)));
        }
        total += tensor.data.len();
        if total > bytes.len() {
            return Err(wrong(&format!("the tensors up to `{}` overlap", tensor.name)));
        }
        tensors.push(tensor);
    }
    Ok(tensors)
}

/// A place in the file.
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
                "a tensor's name is not of 1 to {MAX_NAME} letters, digits, `_` and `.`"
            ))
        })?;
        let shape = self.shape(name)?;
        let [kind] = self.array()?;
        let (dtype, size) = match kind {
            b'f' => (Dtype::F32, 4),
            b'h' => (Dtype::F16, 2),
            _ => return Err(wrong(&format!("tensor `{name}` is of no known type, F16 or F32"))),
        };
        let offset = usize::try_from(u64::from_le_bytes(self.array()?)).unwrap_or(usize::MAX);
        let count = shape.iter().try_fold(size, |product: usize, &n| product.checked_mul(n));
        let data = count.and_then(|count| slice(self.bytes, offset, count)).ok_or_else(|| {
            cut_off(&format!("tensor `{name}` of {shape:?} at {offset} lies outside the file"))
        })?;
        Ok(TzaTensor { name, shape, dtype, data })
    }

    /// The sizes; the layout must be that of convolutions or of biases.
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
