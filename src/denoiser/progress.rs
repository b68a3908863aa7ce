//! Progress of a blocking call.

use std::time::Duration;

use crate::image::Rect;
use crate::ops::tile::Tile;
use crate::plan::tiles::PlacedTile;

/// A step of [`Denoiser::denoise_layers`](crate::Denoiser::denoise_layers).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress<'a> {
    /// Finished calls of the network over all tiles.
    pub done: usize,
    /// Number of calls over all tiles.
    pub total: usize,
    /// How long the network has run on the color's tiles, from the submission of each tile's first
    /// kernel to the end of its last. Excludes exposure, layers, uploads and readbacks.
    pub network_time: Duration,
    /// The tile whose color is ready, once per tile.
    pub tile: Option<FinishedTile<'a>>,
}

/// A tile of denoised color on the GPU, to show before the frame is complete or without reading it
/// back. Work that the callback submits to the denoiser's queue runs before the next tile.
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
    /// The pixels that the tile stores, within the buffer of all pixels that it read.
    pub(super) fn new(buffer: &'a wgpu::Buffer, tile: &Tile, placed: &PlacedTile) -> Self {
        let stride = tile.image_size[0];
        Self { buffer, first: tile.begin[1] * stride + tile.begin[0], stride, rect: placed.stores }
    }

    /// Crops the tile to the image of `width` columns that starts at column `columns`; `None` if
    /// nothing is left.
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
