//! wgdenoise
pub mod error;
pub mod image;
pub mod model;
pub use error::{Error, Result};
pub use image::Image;
