//! The host's view of an operator: it turns tensors into a kernel call.

use super::channel_map::ChannelMap;
use super::need::Need;
use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::tensor::GpuTensor;
use crate::model::{Op, Params};

/// The tensors an operator is bound to.
#[derive(Clone, Copy, Debug)]
pub struct Io<'a> {
    /// The tensors it reads, in order.
    pub inputs: &'a [&'a GpuTensor],
    /// The tensor it writes.
    pub output: &'a GpuTensor,
    /// The max-pool of the output, if the operator [pools](Operator::pools).
    pub pooled: Option<&'a GpuTensor>,
    /// The part of the output to compute. Required by variants that can skip the rest.
    pub need: Option<Need<'a>>,
}

/// One layer's kernel with its weights, ready to be bound to tensors of any size.
pub trait Operator: Send + Sync + std::fmt::Debug {
    /// The call that computes the output, or `None` if the planner has already placed the data.
    ///
    /// # Panics
    /// Panics if the operator pools but `io` has no tensor for it, or reads the activity map but
    /// `io` has no [`Need`].
    fn dispatch(&self, device: &wgpu::Device, io: &Io<'_>) -> Option<Dispatch>;

    /// Whether the call also computes the max-pool of its output.
    fn pools(&self) -> bool {
        false
    }
}

/// A layer of a network, and everything needed to build its operator.
#[derive(Clone, Copy, Debug)]
pub struct LayerRequest<'a> {
    /// Compiles its kernel and holds its weights.
    pub context: &'a Context,
    /// The convolution kernels to use.
    pub kernels: KernelSet,
    /// Its weights; empty for a layer without any.
    pub params: &'a Params,
    /// How each of its inputs is stored.
    pub maps: &'a [&'a ChannelMap],
    /// The next layer, if it reads this one's output and may be computed by the same kernel.
    pub next: Option<Op>,
}
