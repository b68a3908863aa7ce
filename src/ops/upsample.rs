//! Every pixel four times, as 2×2: doubles both sides.

use super::elementwise::{Elementwise, spec};
use crate::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("upsample");

/// The operator.
#[must_use]
pub fn upsample(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}
