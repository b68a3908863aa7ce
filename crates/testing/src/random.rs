//! Reproducible pseudorandom numbers.

use wgdenoise::internals::reference::Tensor;

/// A generator that yields the same numbers for a seed on every machine and in every run:
/// `SplitMix64` (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A value in `[−1, 1)`.
    pub fn value(&mut self) -> f32 {
        // A 32-bit float holds exactly 24 bits.
        (self.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    /// `count` values in `[−1, 1)`.
    pub fn values(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.value()).collect()
    }

    /// A tensor of values in `[−1, 1)`.
    pub fn tensor(&mut self, channels: usize, height: usize, width: usize) -> Tensor {
        Tensor::new(channels, height, width, self.values(channels * height * width))
    }
}
