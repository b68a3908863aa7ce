//! Logistic function, `1 / (1 + exp(−x))`: from any value into `[0, 1]`.

use super::elementwise::{Elementwise, spec};
use super::operator::LayerRequest;
use crate::gpu::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("sigmoid");

/// The operator.
#[must_use]
pub fn sigmoid(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Elementwise {
    sigmoid(layer.context)
}
