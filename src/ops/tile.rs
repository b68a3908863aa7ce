//! Where a tile stands in the images: what both ends of the network must know.

/// Where pixel `(x, y)` stands in a buffer of floats: red (or x) at
/// `offset + y · row_stride + x · pixel_stride`, the others right after it. In elements.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Layout {
    /// The element at which the image begins.
    pub offset: u32,
    /// Elements from one row to the next.
    pub row_stride: u32,
    /// Elements from one pixel to the next: 3 for RGB, 4 for RGBA.
    pub pixel_stride: u32,
    /// 1 if the fourth element of a pixel is its alpha, else 0.
    alpha: u32,
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

    /// Any other layout, without alpha.
    #[must_use]
    pub fn new(offset: u32, row_stride: u32, pixel_stride: u32) -> Self {
        Self { offset, row_stride, pixel_stride, alpha: 0 }
    }

    /// The same with alpha as the fourth element of each pixel. Only colour and output have one.
    #[must_use]
    pub fn with_alpha(self) -> Self {
        Self { alpha: 1, ..self }
    }

    /// Elements of a pixel that are read or written: 3, or 4 with alpha.
    #[must_use]
    pub fn channels(&self) -> u32 {
        3 + self.alpha
    }

    /// Elements that an image of this size needs, up to its last one.
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
    /// Of the bound images, in pixels.
    pub image_size: [u32; 2],
    /// The tile's first pixel in the bound images.
    pub origin: [u32; 2],
    /// The first pixel to store.
    pub begin: [u32; 2],
    /// One past the last pixel to store.
    pub end: [u32; 2],
    /// Layout of the colour.
    pub color: Layout,
    /// Layout of the albedo; ignored if there is none.
    pub albedo: Layout,
    /// Layout of the normal; ignored if there is none.
    pub normal: Layout,
    /// Layout of the result.
    pub output: Layout,
}
