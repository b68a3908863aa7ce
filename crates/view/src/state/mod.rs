//! What the window is told to show and do, without a window: plain values that are easy to test.

pub(crate) mod keys;
pub(crate) mod looking;
pub(crate) mod pixel;
pub(crate) mod sequence;
pub(crate) mod settings;
pub(crate) mod settling;
pub(crate) mod tone;
pub(crate) mod transform;
