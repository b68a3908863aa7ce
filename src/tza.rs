//! Weights files of Intel Open Image Denoise (TZA).

pub use crate::model::tza::{is_tza, to_safetensors};
