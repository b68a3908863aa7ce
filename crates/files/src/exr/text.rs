//! Names in EXR headers.

use exr::meta::attribute::Text;

/// A name in UTF-8, as renderers write it, or else in Latin-1.
pub(crate) fn name(text: &Text) -> String {
    std::str::from_utf8(text.bytes()).map_or_else(|_| text.to_string(), String::from)
}
