//! The location of a tile in the images, for the kernels at both ends of the network.

/// The layout of an image in a buffer of floats. For pixel `(x, y)`, the first channel (red or x)
/// is at element `offset + y · row_stride + x · pixel_stride`, and the others follow it directly.
/// All values count elements, not bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Layout {
    /// The first element of the image.
    pub offset: u32,
    /// Elements from one row to the next.
    pub row_stride: u32,
    /// Elements from one pixel to the next: 3 for RGB, 4 for RGBA.
    pub pixel_stride: u32,
    /// Elements of a pixel that are read or written: 4 if the fourth is its alpha.
    channels: u32,
}

impl Layout {
    /// RGB without gaps.
    #[must_use]
    pub fn packed(width: u32) -> Self {
        Self::new(0, width * 3, 3)
    }

    /// RGBA without gaps.
    #[must_use]
    pub fn packed_rgba(width: u32) -> Self {
        Self::new(0, width * 4, 4).with_alpha()
    }

    /// This many channels without gaps: 2 for motion, 1 for depth.
    #[must_use]
    pub fn packed_channels(width: u32, channels: u32) -> Self {
        Self::new(0, width * channels, channels).with_channels(channels)
    }

    /// Any layout of three channels.
    #[must_use]
    pub fn new(offset: u32, row_stride: u32, pixel_stride: u32) -> Self {
        Self { offset, row_stride, pixel_stride, channels: 3 }
    }

    /// Adds alpha as the fourth element of each pixel. Only color and output may have it.
    #[must_use]
    pub fn with_alpha(self) -> Self {
        self.with_channels(4)
    }

    /// Changes the number of channels: 3 or 4 for light, at least 2 for motion and 1 for depth.
    #[must_use]
    pub fn with_channels(self, channels: u32) -> Self {
        Self { channels, ..self }
    }

    /// Elements of a pixel that are read or written.
    #[must_use]
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// Elements that an image of this size needs, up to and including its last one.
    #[must_use]
    pub fn elements(&self, width: u32, height: u32) -> u64 {
        let [x, y] = [u64::from(width - 1), u64::from(height - 1)];
        u64::from(self.offset)
            + y * u64::from(self.row_stride)
            + x * u64::from(self.pixel_stride)
            + u64::from(self.channels())
    }
}

/// The uniform `Tile` of the kernels that read or write images.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Tile {
    /// Size of the bound images in pixels.
    pub image_size: [u32; 2],
    /// The tile's first pixel in the bound images.
    pub origin: [u32; 2],
    /// The first pixel to store.
    pub begin: [u32; 2],
    /// One past the last pixel to store.
    pub end: [u32; 2],
    /// Layout of the color, or of the further layer to denoise.
    pub color: Layout,
    /// Layout of the albedo; ignored without one.
    pub albedo: Layout,
    /// Layout of the normal; ignored without one.
    pub normal: Layout,
    /// Layout of the result.
    pub output: Layout,
    /// Layout of the color that the network reads; ignored unless a further layer is denoised.
    pub beauty: Layout,
    /// Layout of the motion; ignored without motion.
    pub motion: Layout,
    /// Layout of the depth; ignored without depth.
    pub depth: Layout,
}
