//! Reads the weights files of Open Image Denoise (TZA) into this project's format.
//!
//! The channel order differs: those networks were trained with the upsampled channels before the
//! skip's, while this project's weights files have the skip's first; see `weights-format.md`.

mod convert;
mod kind;
mod reader;

pub use convert::to_safetensors;
pub use kind::{KINDS, TzaKind, for_inputs};
pub use reader::{TzaTensor, is_tza, read};
