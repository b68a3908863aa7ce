//! Logistic function, `1 / (1 + exp(−x))`: from any value into `[0, 1]`.

use super::elementwise::{Elementwise, spec};
use crate::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("sigmoid");

/// The operator.
#[must_use]
pub fn sigmoid(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}
