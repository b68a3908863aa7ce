//! Every operator, written as plainly as possible, on the CPU.
//!
//! The GPU is tested against this reference, which shares only names and definitions with it and is
//! itself tested against `PyTorch`. It is never optimized: each result is one sum in 64-bit floats,
//! rounded once to 32 bits.

mod accumulate;
mod activity;
mod autoexposure;
mod concat;
mod conv1x1;
mod conv3x3;
mod conv_logits;
mod conv_transpose;
mod demodulation;
mod denoise;
mod gather;
mod head;
mod input_conv;
mod input_process;
mod kernel_pyramid;
mod layer;
mod max_pool;
pub mod network;
mod output_process;
mod pyramid;
mod repair;
mod sigmoid;
mod tensor;
mod transfer_function;
mod up_conv;
mod upsample;

pub use accumulate::{Frame, History, Past, accumulate};
pub use activity::{Activity, TileOfImage, activity};
pub use autoexposure::autoexposure;
pub use concat::concat;
pub use conv_logits::conv_logits;
pub use conv_transpose::conv_transpose;
pub use conv1x1::conv1x1;
pub use conv3x3::conv3x3;
pub use demodulation::{modulated, texture};
pub use denoise::{Images, denoise, denoise_by};
pub use gather::gather;
pub use head::{head, keep_clean};
pub use input_conv::input_conv;
pub use input_process::{input_process, input_process_in};
pub use kernel_pyramid::kernel_pyramid;
pub use layer::{denoise_layer, repair_layer};
pub use max_pool::max_pool;
pub use network::{apply, run, run_by};
pub use output_process::{output_process, output_process_in};
pub use pyramid::{Light, finest, pyramid};
pub use repair::{GREY, MOST, Repaired, fill, repair, repair_in};
pub use sigmoid::sigmoid;
pub use tensor::Tensor;
pub use transfer_function::{LARGEST, decode, encode, pu, pu_inverse};
pub use up_conv::up_conv;
pub use upsample::upsample;
