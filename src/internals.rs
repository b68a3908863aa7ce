//! Internals for this repository's tests and benches. Not part of the public API: anything here may
//! change in any release.

/// Kernels, contexts and tensors on a device.
pub mod gpu {
    pub use crate::gpu::*;
}
/// Networks, weights files and their cost.
pub mod model {
    pub use crate::model::*;
}
/// The host side of the operators.
pub mod ops {
    pub use crate::ops::*;
}
/// Tiles, halos and storage.
pub mod plan {
    pub use crate::plan::*;
}
/// The naive CPU functions.
pub mod reference {
    pub use crate::reference::*;
}
pub use crate::denoiser::self_test;
/// The shader modules and their composer.
pub mod shader {
    pub use crate::shader::*;
}
