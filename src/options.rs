//! What a caller can choose.

use crate::ops::simd;

/// How tensors are stored between layers. Arithmetic is in 32-bit float either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit float: four bytes per channel.
    F32,
    /// 16-bit float: half the memory and bandwidth. Each store rounds by 2⁻¹¹ of the value, which
    /// adds 0.1 to 0.2 % to the error that the network leaves (`docs/performance.md`).
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

    /// Bytes of one texel of four channels.
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

/// Which variant of the convolutions runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum KernelSet {
    /// The fastest for the adapter: `Simd` where it runs, else `Tiled`.
    #[default]
    Auto,
    /// The readable definition: one pixel and four output channels per invocation.
    Plain,
    /// For GPUs: input and weights staged in workgroup memory.
    Tiled,
    /// For CPU drivers (lavapipe): straight-line code, weights by subgroup broadcast.
    Simd,
}

impl KernelSet {
    /// `Auto` replaced by what it stands for on this device.
    #[must_use]
    pub fn resolve(self, device: &wgpu::Device) -> Self {
        match self {
            Self::Auto if Self::Simd.runs_on(device) => Self::Simd,
            Self::Auto => Self::Tiled,
            chosen => chosen,
        }
    }

    /// Whether the variant gives right results on this device. `Simd` needs a CPU driver, which
    /// reads 0 outside of textures, with subgroups of at least eight invocations and the feature
    /// `SUBGROUP`; the others run everywhere.
    #[must_use]
    pub fn runs_on(self, device: &wgpu::Device) -> bool {
        let info = device.adapter_info();
        self != Self::Simd
            || info.device_type == wgpu::DeviceType::Cpu
                && info.subgroup_min_size >= simd::LANES
                && device.features().contains(wgpu::Features::SUBGROUP)
    }
}

/// How a [`Denoiser`](crate::Denoiser) works.
#[derive(Clone, Debug)]
pub struct Options {
    /// How tensors are stored; 16-bit float unless said.
    pub precision: Precision,
    /// Most bytes of GPU memory for tensors and, in the blocking call, images; 2 GiB unless
    /// said. The adapter's limits bound tiles as well.
    pub memory_bytes: u64,
    /// Side of a tile with its overlap, in pixels; `None` picks the largest within the budget.
    pub tile: Option<u32>,
    /// Which variant of the convolutions runs.
    pub kernels: KernelSet,
    /// Whether blocks of 16×16 pixels that have no noise, such as an empty background, keep
    /// their colour and skip the network; see [`ops::activity`](crate::ops::activity). The
    /// plain kernels never skip.
    pub skip_clean: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            precision: Precision::F16,
            memory_bytes: 2 << 30,
            tile: None,
            kernels: KernelSet::Auto,
            skip_clean: true,
        }
    }
}
