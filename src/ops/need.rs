//! Decides which part of a tensor a convolution must compute.
//!
//! For each block of 16×16 pixels of the tile, the activity map holds the distance in blocks to the
//! nearest active block. A convolution runs where that is at most its layer's reach. Elsewhere it
//! leaves its output unchanged, since nothing stored depends on it.

use super::activity::{self, LAYERS};
use super::packing::filled_buffer;
use crate::gpu::kernel::Binding;
use crate::plan::halo::BLOCK;

/// The inputs to a layer's decision.
#[derive(Clone, Copy, Debug)]
pub struct Need<'a> {
    /// The activity map.
    pub map: &'a wgpu::TextureView,
    /// Both sides of the tensor are the tile's divided by `2^level`.
    pub level: u32,
    /// How many blocks around an active one the layer must compute.
    pub reach: u32,
}

/// The uniform `Need` of the convolutions.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct NeedUniform {
    /// Layer of the map.
    pub layer: u32,
    /// Texel of the map = pixel of the tensor `>> shift`.
    pub shift: u32,
    /// Largest distance at which to compute.
    pub reach: u32,
    padding: u32,
}

/// The binding of [`NeedUniform`].
pub const UNIFORM: Binding =
    Binding::Uniform { bytes: size_of::<NeedUniform>() as u64, dynamic: false };

impl Need<'_> {
    /// The uniform for a kernel that decides for `footprint` columns of the tensor at once, a power
    /// of two, and for at most as many rows.
    #[must_use]
    pub fn buffer(&self, device: &wgpu::Device, footprint: u32) -> wgpu::Buffer {
        let uniform = uniform(self.level, self.reach, footprint);
        filled_buffer(device, "need", bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM)
    }
}

/// A map in which everything is needed at any reach.
#[must_use]
pub fn everything(device: &wgpu::Device) -> wgpu::TextureView {
    // New textures are zero, and reads beyond them return zero too.
    activity::map(device, [1, 1])
}

/// Chooses the map layer in which one texel covers the footprint.
fn uniform(level: u32, reach: u32, footprint: u32) -> NeedUniform {
    let covered = (footprint.ilog2() + level).max(BLOCK.ilog2());
    let layer = covered - BLOCK.ilog2();
    // In networks deeper than the map's layers, the lowest levels are computed completely.
    if layer >= LAYERS {
        return NeedUniform { layer: 0, shift: 31, reach: u32::MAX, padding: 0 };
    }
    NeedUniform { layer, shift: covered - level, reach, padding: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_texel_of_the_map_covers_the_footprint() {
        let view = |level, footprint: u32| {
            let NeedUniform { layer, shift, .. } = uniform(level, 1, footprint);
            // Pixels of the tensor per texel, and the same in pixels of the image.
            assert_eq!((1 << shift) << level, BLOCK << layer, "level {level}");
            assert!(1 << shift >= footprint, "level {level}");
            (layer, shift)
        };
        assert_eq!([view(0, 4), view(2, 4), view(3, 4)], [(0, 4), (0, 2), (1, 2)]);
        assert_eq!([view(0, 16), view(4, 16)], [(0, 4), (4, 4)]);
        assert_eq!(uniform(5, 1, 16).reach, u32::MAX);
    }
}
