//! Concatenation of channels, which moves no data: the planner gives both inputs a range of
//! layers of one texture (see [`crate::plan::storage`]), the second at a multiple of four
//! channels, and the reader's weights follow the [`ChannelMap`] of the result.

use super::channel_map::ChannelMap;
use super::operator::{Io, LayerRequest, Operator};
use crate::gpu::kernel::Dispatch;

/// The operator.
#[derive(Debug)]
pub struct Concat;

/// How the concatenation is stored: the first input's channels, then the second's.
#[must_use]
pub fn channel_map(first: &ChannelMap, second: &ChannelMap) -> ChannelMap {
    let offset = first.iter().flatten().count();
    let shifted = second.iter().map(|channel| channel.map(|c| c + offset));
    first.iter().copied().chain(shifted).collect()
}

impl Operator for Concat {
    fn dispatch(&self, _: &wgpu::Device, _: &Io<'_>) -> Option<Dispatch> {
        None
    }
}

/// The operator of a layer.
pub(super) fn operator(_: &LayerRequest<'_>) -> Concat {
    Concat
}
