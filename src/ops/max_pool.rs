//! Maximum over 2×2 pixels: halves both sides, which must be even.

use super::elementwise::{Elementwise, spec};
use crate::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("max_pool");

/// The operator.
#[must_use]
pub fn max_pool(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}
