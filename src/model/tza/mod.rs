//! Weights of Open Image Denoise, read from its own files (TZA) into this project's format.
//!
//! The two differ in one thing: these networks were trained with the upsampled channels before
//! the skip's, where a weights file has the skip's first; see `weights-format.md`.

mod convert;
mod kind;
mod reader;

pub use convert::to_safetensors;
pub use kind::{KINDS, TzaKind, for_inputs};
pub use reader::{TzaTensor, is_tza, read};
