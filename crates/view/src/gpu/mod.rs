//! The window's device: images on it, and drawing them.

pub(crate) mod canvas;
pub(crate) mod host;
pub(crate) mod levels;
pub(crate) mod screen;
pub(crate) mod texture;
