//! Averages denoised frames of an animation along their motion, so that what noise is left does not
//! flicker.
//!
//! Each pixel of a frame is averaged with what the frames around it show of the same surface. Motion
//! vectors lead there ([`Offsets`]); they count as far as both frames agree on what they see
//! ([`agreement`]). [`Evidence`] finds out how a renderer means its motion vectors.

mod agreement;
mod convention;
mod evidence;
mod mean;
mod offsets;
mod sample;
mod sharp;
mod shot;
mod trend;

pub use agreement::agreement;
pub use convention::{Convention, Motion};
pub use evidence::Evidence;
pub use mean::{Part, mean};
pub use offsets::Offsets;
pub use shot::Shot;
