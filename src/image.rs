//! Images on the CPU, and rectangles in them.

use crate::error::{Error, Result};

/// Three channels of 32-bit float, row by row from the top left, without padding.
///
/// Color is linear and scene-referred, at any exposure; albedo is linear in `[0, 1]`; normals have
/// components in `[−1, 1]`, in camera or world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Image {
    /// Wraps `width · height` pixels.
    ///
    /// # Errors
    /// Fails if a side is 0 or the number of pixels is not `width · height`.
    pub fn new(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Result<Self> {
        if width == 0 || height == 0 || pixels.len() != width as usize * height as usize {
            return Err(Error::Image(format!(
                "{width}×{height} needs sides of at least 1 and {} pixels, found {} pixels",
                u64::from(width) * u64::from(height),
                pixels.len()
            )));
        }
        Ok(Self { width, height, pixels })
    }

    /// An image with every pixel set to `pixel`.
    ///
    /// # Errors
    /// Fails if a side is 0 or the pixels do not fit in main memory.
    pub fn filled(width: u32, height: u32, pixel: [f32; 3]) -> Result<Self> {
        let count = width as usize * height as usize;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).map_err(|_| {
            let mib = (count >> 20) * size_of::<[f32; 3]>();
            Error::OutOfMemory(format!(
                "an image of {width}×{height} pixels needs {mib} MiB of main memory"
            ))
        })?;
        pixels.resize(count, pixel);
        Self::new(width, height, pixels)
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// `(width, height)`.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// All pixels, row by row from the top left.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// All pixels, mutable.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.pixels
    }

    /// One row of pixels, counted from the top. Panics if `y` is not below the height.
    #[must_use]
    pub fn row(&self, y: u32) -> &[[f32; 3]] {
        let width = self.width as usize;
        &self.pixels[y as usize * width..][..width]
    }
}

/// A rectangle of pixels: `begin` is inclusive, `end` exclusive; x comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column and row.
    pub begin: [u32; 2],
    /// One past the last column and row.
    pub end: [u32; 2],
}

impl Rect {
    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.end[0] - self.begin[0], self.end[1] - self.begin[1]]
    }
}
