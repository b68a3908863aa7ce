//! Every pixel four times, as 2×2: doubles both sides.

use super::elementwise::{Elementwise, spec};
use super::operator::LayerRequest;
use crate::gpu::kernel::{Context, KernelSpec};

/// The kernel.
pub const SPEC: KernelSpec = spec("upsample");

/// The operator.
#[must_use]
pub fn upsample(context: &Context) -> Elementwise {
    Elementwise::new(context, &SPEC)
}

/// The operator of a layer.
pub(super) fn operator(layer: &LayerRequest<'_>) -> Elementwise {
    upsample(layer.context)
}
