//! Averages denoised frames of an animation along their motion, so that residual noise does not
//! flicker.
//!
//! Each pixel is averaged with the pixels of nearby frames that show the same surface. Motion
//! vectors lead there ([`Offsets`]), and each frame counts as far as both agree on what they show
//! ([`agreement`]). [`Evidence`] finds the convention that a renderer's vectors follow.

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
