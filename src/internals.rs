//! What the tests and benches of this repository use beyond the public interface. Not part of it:
//! anything here may change in any release.

/// Kernels, contexts and tensors on a device.
pub mod gpu {
    pub use crate::gpu::*;
}
/// Networks, weights files and what they cost.
pub mod model {
    pub use crate::model::*;
}
/// Host sides of the operators.
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
/// The shaders' modules and what composes them.
pub mod shader {
    pub use crate::shader::*;
}
