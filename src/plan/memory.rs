//! A tile's share of the memory budget.

/// The bytes a tile needs: a number per pixel, with a minimum for one of its buffers, plus a number
/// that does not depend on its size.
#[derive(Clone, Copy, Debug, Default)]
pub struct Footprint {
    /// Bytes per pixel in total, including that buffer; more than `buffer_per_pixel`.
    pub per_pixel: u64,
    /// Bytes per pixel of that buffer.
    pub buffer_per_pixel: u64,
    /// Minimum bytes of that buffer, however small the tile.
    pub buffer_least: u64,
    /// Bytes for the whole image, however many tiles it has.
    pub picture: u64,
}

impl Footprint {
    /// Bytes for a tile of this many pixels.
    #[must_use]
    pub fn bytes(&self, pixels: u64) -> u64 {
        let buffer = (pixels * self.buffer_per_pixel).max(self.buffer_least);
        pixels * (self.per_pixel - self.buffer_per_pixel) + buffer + self.picture
    }

    /// The maximum number of pixels that fit into this many bytes; 0 if none do.
    #[must_use]
    pub fn most_pixels(&self, bytes: u64) -> u64 {
        let bytes = bytes.saturating_sub(self.picture);
        let beside = bytes.saturating_sub(self.buffer_least);
        (bytes / self.per_pixel).min(beside / (self.per_pixel - self.buffer_per_pixel))
    }
}
