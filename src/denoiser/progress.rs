//! What a blocking call reports while it runs.

use std::time::Duration;

use crate::image::Rect;
use crate::ops::tile::Tile;
use crate::plan::tiles::PlacedTile;

/// A step of [`Denoiser::denoise_layers`](crate::Denoiser::denoise_layers).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress<'a> {
    /// Finished calls of the network, of all tiles.
    pub done: usize,
    /// All calls of all tiles.
    pub total: usize,
    /// How long the network has run on the color's tiles, from the submission of each tile's first
    /// kernel to the end of its last. Exposure, layers, uploads and readbacks are left out.
    pub network_time: Duration,
    /// The tile whose color is ready, once per tile.
    pub tile: Option<FinishedTile<'a>>,
}

/// Denoised color of a tile on the GPU, to be shown before the frame is whole or without reading it
/// back. What the caller submits to the denoiser's queue within the callback comes before the next
/// tile.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FinishedTile<'a> {
    /// Linear red, green and blue in 32-bit float at the input's exposure, 12 bytes per pixel, with
    /// usages `STORAGE` and `COPY_SRC`. Alpha has not been settled yet.
    pub buffer: &'a wgpu::Buffer,
    /// Index of the tile's first pixel in the buffer.
    pub first: u32,
    /// Pixels from one row of the buffer to the next.
    pub stride: u32,
    /// The tile's place in the image.
    pub rect: Rect,
}

impl<'a> FinishedTile<'a> {
    /// The pixels that the tile stores, from the buffer of all that it read.
    pub(super) fn new(buffer: &'a wgpu::Buffer, tile: &Tile, placed: &PlacedTile) -> Self {
        let stride = tile.image_size[0];
        Self { buffer, first: tile.begin[1] * stride + tile.begin[0], stride, rect: placed.stores }
    }

    /// The same tile in an image that lacks `columns` at the left and ends after `width` more;
    /// `None` if nothing is left of it.
    pub(super) fn cropped(self, columns: u32, width: u32) -> Option<Self> {
        let Rect { begin: [left, top], end: [right, bottom] } = self.rect;
        let (from, to) = (left.max(columns), right.min(columns + width));
        (from < to).then(|| Self {
            first: self.first + from - left,
            rect: Rect { begin: [from - columns, top], end: [to - columns, bottom] },
            ..self
        })
    }
}
