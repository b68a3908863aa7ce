//! The window's device: images on it, and how they are drawn.

pub(crate) mod canvas;
pub(crate) mod host;
pub(crate) mod levels;
pub(crate) mod screen;
pub(crate) mod texture;
