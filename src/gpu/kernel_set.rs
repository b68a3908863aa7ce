//! The variants of the convolution kernels.

use super::matrix_shape::MatrixShape;

/// Subgroup size that the kernels for CPU drivers need. llvmpipe has it with 256-bit vectors, its
/// default on current CPUs; with narrower ones, another variant must run.
pub const SIMD_LANES: u32 = 8;

/// The variants of the convolution kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum KernelSet {
    /// The fastest on the adapter: `Simd` where it runs, else `Matrix` if
    /// [`Options::matrix`](crate::Options::matrix) gives a shape and its test passes, else `Tiled`.
    #[default]
    Auto,
    /// The readable definition: one pixel and four output channels per invocation.
    Plain,
    /// For GPUs: stages input and weights in workgroup memory, for 16×16 pixels at a time.
    Tiled,
    /// Like `Tiled`, bit for bit, but for 32×8 pixels and with half as many barriers. `Auto` does
    /// not choose it: no GPU has compared them yet.
    Wide,
    /// `Tiled` with 16-bit floats, which many GPUs multiply and add at twice the rate: products and
    /// their sums over every four input channels have 16 bits, the sums of those 32. Needs the
    /// feature `SHADER_F16`. `Auto` does not choose it: no GPU has timed it yet.
    Half,
    /// For CPU drivers (lavapipe): straight-line code, with weights broadcast across the subgroup.
    Simd,
    /// For GPUs with matrix units: computes convolutions as matrix products of this shape.
    Matrix(MatrixShape),
}

impl KernelSet {
    /// Resolves `Auto` to the fastest set that needs no test on this device: `Simd` where it runs,
    /// else `Tiled`. A [`Denoiser`](crate::Denoiser) also considers `Matrix`.
    #[must_use]
    pub fn resolve(self, device: &wgpu::Device) -> Self {
        match self {
            Self::Auto if Self::Simd.runs_on(device) => Self::Simd,
            Self::Auto => Self::Tiled,
            chosen => chosen,
        }
    }

    /// Whether the variant can run on this device. `Simd` needs a CPU driver, which reads 0 outside
    /// textures, subgroups of at least eight invocations and the feature `SUBGROUP`; `Matrix` needs
    /// [`MatrixShape::runs_on`], `Half` the feature `SHADER_F16`; the others run everywhere.
    #[must_use]
    pub fn runs_on(self, device: &wgpu::Device) -> bool {
        let info = device.adapter_info();
        match self {
            Self::Auto | Self::Plain | Self::Tiled | Self::Wide => true,
            Self::Simd => {
                info.device_type == wgpu::DeviceType::Cpu
                    && info.subgroup_min_size >= SIMD_LANES
                    && device.features().contains(wgpu::Features::SUBGROUP)
            }
            Self::Half => device.features().contains(wgpu::Features::SHADER_F16),
            Self::Matrix(shape) => shape.runs_on(device),
        }
    }

    /// Whether the kernels stage pixels in workgroup memory, as suits GPUs.
    #[must_use]
    pub fn is_for_gpus(self) -> bool {
        matches!(self, Self::Tiled | Self::Wide | Self::Half | Self::Matrix(_))
    }

    /// A notice if a device runs slower kernels than it could because a feature was not requested.
    pub(crate) fn lost_speed(device: &wgpu::Device) -> Option<String> {
        let info = device.adapter_info();
        let could = info.device_type == wgpu::DeviceType::Cpu
            && info.subgroup_min_size >= SIMD_LANES
            && !device.features().contains(wgpu::Features::SUBGROUP);
        could.then(|| {
            format!(
                "{} was opened without the feature SUBGROUP, so the slower kernels for GPUs run; \
                 request wgdenoise::required_features(&adapter)",
                info.name
            )
        })
    }

    /// The variant's requirements, for the error message if they are not met.
    pub(crate) fn needs(self) -> &'static str {
        match self {
            Self::Auto | Self::Plain | Self::Tiled | Self::Wide => "nothing",
            Self::Simd => "a CPU driver with subgroups of at least 8 and the feature SUBGROUP",
            Self::Half => "the feature SHADER_F16",
            Self::Matrix(_) => "the features of the shape and subgroups of its one size",
        }
    }
}

impl std::fmt::Display for KernelSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Matrix(shape) => write!(f, "Matrix {0}×{0} {1:?}", shape.side, shape.factor),
            other => write!(f, "{other:?}"),
        }
    }
}
