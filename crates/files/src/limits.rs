//! How large images may be.

use super::Problem;

/// The largest image to read. Larger ones are refused before memory is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most pixels per image; 16384 × 16384 by default. Three images of that size take 9 GiB of
    /// memory.
    pub pixels: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { pixels: 16384 * 16384 }
    }
}

impl Limits {
    /// Most bytes that one block of an EXR file may unpack to: 1 GiB, or more if more pixels than
    /// the default are accepted.
    #[must_use]
    pub fn block_bytes(self) -> u64 {
        self.pixels.max(Self::default().pixels).saturating_mul(4)
    }

    /// Checks the sides of an image.
    ///
    /// # Errors
    /// If it has no pixels, or more than accepted.
    pub fn check_size(self, width: u64, height: u64) -> Result<(), Problem> {
        match width.checked_mul(height) {
            Some(0) => Err(Problem::Damaged(format!("is {width}×{height} pixels: there are none"))),
            Some(pixels) if pixels <= self.pixels => Ok(()),
            _ => Err(Problem::TooManyPixels { width, height, most: self.pixels }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_from_one_pixel_to_the_limit_pass_and_others_do_not() {
        let limits = Limits::default();
        assert!(limits.check_size(1, 1).is_ok() && limits.check_size(16384, 16384).is_ok());
        assert!(limits.check_size(0, 5).is_err() && limits.check_size(16384, 16385).is_err());
        let most = Limits { pixels: u64::MAX };
        assert!(most.check_size(16384, 16385).is_ok() && most.block_bytes() == u64::MAX);
        assert!(most.check_size(u64::MAX, u64::MAX).is_err());
    }
}
