//! Reads color, albedo and normals from image files and writes the result. Also has what programs
//! need around that: names of inputs and frames, weights files, and whether weights suit an image.
//!
//! The format of an input is recognized by its content, that of an output by its extension. Colors
//! are linear in memory, with Rec. 709 primaries unless the file says otherwise.

pub mod choice;
pub mod comparison;
pub mod exr;
pub mod features;
pub mod fit;
pub mod frames;
pub mod guard;
pub mod inputs;
pub mod layers;
pub mod weights;

mod aux_file;
mod conventions;
mod describe;
mod display;
mod draft;
mod error;
mod escape;
mod format;
mod identity;
mod layer;
mod ldr;
mod light;
mod limits;
mod motion;
mod normals;
mod output;
mod pick;
mod picture;
mod preview;
mod primaries;
mod selection;
mod stream;
mod view;
mod views;
mod wanted;
mod window;

pub use describe::{Description, LayerInfo, ViewInfo};
pub use draft::discard_drafts;
pub use error::{FileError, Problem};
pub use escape::{escaped, escaped_json, escaped_lines};
pub use format::{Format, open_file};
pub use identity::Identity;
pub use light::LayersWish;
pub use limits::Limits;
pub use motion::{MotionLayer, MotionPick, MotionWish};
pub use output::Out;
pub use output::check as check_output;
pub use output::check_place;
pub use output::replace;
pub use picture::Picture;
pub use preview::{Preview, exposed};
pub use selection::Selection;
pub use stream::{forget, is_standard, is_stream};
pub use view::{Denoised, NoisyLayer, View};
pub use wanted::LayerChoice;

#[cfg(test)]
mod tests;
