//! Devices and their capabilities, and kernels and tensors on them.

mod compiled;
pub mod device;
pub mod kernel;
pub mod kernel_set;
pub mod matrix_shape;
pub mod pipeline_file;
pub mod precision;
pub mod requirements;
pub(crate) mod scopes;
pub mod tensor;
pub(crate) mod tensor_io;
mod unsafe_calls;
pub(crate) mod wait;
