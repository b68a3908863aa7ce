//! Names in EXR headers.

use exr::meta::attribute::Text;

/// Decodes a name as UTF-8, as renderers write it, or else as Latin-1.
pub(crate) fn name(text: &Text) -> String {
    std::str::from_utf8(text.bytes()).map_or_else(|_| text.to_string(), String::from)
}
