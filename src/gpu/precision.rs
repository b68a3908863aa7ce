//! How tensors are stored.

/// How tensors are stored between layers. Arithmetic uses 32-bit floats either way, except that
/// [`KernelSet::Matrix`](crate::KernelSet::Matrix) may round factors to 16 bits, with 32-bit sums,
/// and [`KernelSet::Half`](crate::KernelSet::Half) computes in 16 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit float: four bytes per channel.
    F32,
    /// 16-bit float: half the memory and bandwidth. Each store rounds to nearest, by at most 2⁻¹¹
    /// of the value, which is lost in the network's own error (`docs/performance.md`).
    #[default]
    F16,
}

impl Precision {
    /// The texel format of a tensor: four channels.
    #[must_use]
    pub fn texture_format(self) -> wgpu::TextureFormat {
        match self {
            Self::F32 => wgpu::TextureFormat::Rgba32Float,
            Self::F16 => wgpu::TextureFormat::Rgba16Float,
        }
    }

    /// Bytes of one four-channel texel.
    #[must_use]
    pub fn texel_bytes(self) -> u64 {
        match self {
            Self::F32 => 16,
            Self::F16 => 8,
        }
    }

    /// The largest value that can be stored; larger ones are clamped to it.
    #[must_use]
    pub fn largest(self) -> f64 {
        match self {
            Self::F32 => f64::from(f32::MAX),
            Self::F16 => f64::from(half::f16::MAX),
        }
    }
}
