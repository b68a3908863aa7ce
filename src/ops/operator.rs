//! What every operator of a network is to its host: something that gives a call for tensors.

use super::channel_map::ChannelMap;
use super::need::Need;
use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::tensor::GpuTensor;
use crate::model::{Op, Params};

/// What an operator is bound to.
#[derive(Clone, Copy, Debug)]
pub struct Io<'a> {
    /// What it reads, in order.
    pub inputs: &'a [&'a GpuTensor],
    /// What it makes.
    pub output: &'a GpuTensor,
    /// Where the max-pool of the output goes, if the operator [pools](Operator::pools).
    pub pooled: Option<&'a GpuTensor>,
    /// Which part of the output must be made; variants that can leave out the rest need it.
    pub need: Option<Need<'a>>,
}

/// One layer's kernel with its weights, ready to be bound to tensors of any size.
pub trait Operator: Send + Sync + std::fmt::Debug {
    /// The call that makes the output, or `None` where the planner has already put the data in
    /// place.
    ///
    /// # Panics
    /// If the operator pools and `io` has no place for it, or asks what is needed and `io` does
    /// not say.
    fn dispatch(&self, device: &wgpu::Device, io: &Io<'_>) -> Option<Dispatch>;

    /// Whether the call also makes the max-pool of its output.
    fn pools(&self) -> bool {
        false
    }
}

/// A layer of a network, to be made ready for a device.
#[derive(Clone, Copy, Debug)]
pub struct LayerRequest<'a> {
    /// Where its kernel is compiled and its weights go.
    pub context: &'a Context,
    /// Which variant of the convolutions runs.
    pub kernels: KernelSet,
    /// Its weights; empty for a layer without.
    pub params: &'a Params,
    /// How each of its inputs is stored.
    pub maps: &'a [&'a ChannelMap],
    /// The next layer, if that reads what this one makes: it may be made by the same kernel.
    pub next: Option<Op>,
}
