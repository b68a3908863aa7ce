//! The window's state and behavior, as plain values that are tested without a window.

pub(crate) mod entry;
pub(crate) mod keys;
pub(crate) mod latest;
pub(crate) mod looking;
pub(crate) mod magma;
pub(crate) mod pending;
pub(crate) mod pixel;
pub(crate) mod sequence;
pub(crate) mod settings;
pub(crate) mod settling;
pub(crate) mod tone;
pub(crate) mod transform;
