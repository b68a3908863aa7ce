//! Maximum over 2×2 pixels: halves both sides, which must be even.

use super::elementwise::{Elementwise, spec};
use super::operator::LayerRequest;
use crate::gpu::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("max_pool");

/// The operator.
#[must_use]
pub fn max_pool(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Elementwise {
    max_pool(layer.context)
}
