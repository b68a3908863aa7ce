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

pub use agreement::agreement;
pub use convention::{Convention, Motion};
pub use evidence::Evidence;
pub use mean::{Part, mean};
pub use offsets::Offsets;
pub use sharp::sharpness;

use wgdenoise::Image;

/// A denoised frame and what tells its surfaces apart, all of one size.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Linear light.
    pub color: &'a Image,
    /// Linear albedo in [0, 1].
    pub albedo: Option<&'a Image>,
    /// Normals in [−1, 1].
    pub normal: Option<&'a Image>,
}
