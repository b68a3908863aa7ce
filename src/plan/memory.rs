//! What a tile takes of the memory budget.

/// Bytes that a tile needs: so many per pixel, but at least so many for one of its buffers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Footprint {
    /// Bytes per pixel of everything, that buffer included; above those of the buffer.
    pub per_pixel: u64,
    /// Bytes per pixel of the buffer.
    pub buffer_per_pixel: u64,
    /// Bytes of the buffer at least, however small the tile is.
    pub buffer_least: u64,
}

impl Footprint {
    /// Bytes for a tile of so many pixels.
    #[must_use]
    pub fn bytes(&self, pixels: u64) -> u64 {
        let buffer = (pixels * self.buffer_per_pixel).max(self.buffer_least);
        pixels * (self.per_pixel - self.buffer_per_pixel) + buffer
    }

    /// The most pixels that so many bytes are enough for; 0 if they are not enough for any.
    #[must_use]
    pub fn most_pixels(&self, bytes: u64) -> u64 {
        let beside = bytes.saturating_sub(self.buffer_least);
        (bytes / self.per_pixel).min(beside / (self.per_pixel - self.buffer_per_pixel))
    }
}
