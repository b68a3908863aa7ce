//! Matrix shapes that an adapter can multiply.

use super::precision::Precision;

/// Subgroups per workgroup of the matrix kernels.
pub const SUBGROUPS: u32 = 4;

/// The type that the factors of a product are rounded to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Factor {
    /// 16-bit float; values beyond ±65504 are clamped.
    F16,
    /// 32-bit float.
    F32,
}

/// A matrix shape that an adapter multiplies with sums in 32-bit float.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MatrixShape {
    /// Rows and columns of every matrix: 8 or 16.
    pub side: u32,
    /// Type of the factors.
    pub factor: Factor,
    /// Invocations per subgroup.
    pub lanes: u32,
}

impl MatrixShape {
    /// The best shape for an adapter, or `None` if it reports none that fits. Factors have 32 bits
    /// if tensors do and the adapter multiplies them in matrices of 8 (staged tiles of 16 would not
    /// fit into workgroup memory), else 16 bits.
    #[must_use]
    pub fn of(adapter: &wgpu::Adapter, precision: Precision) -> Option<Self> {
        let info = adapter.get_info();
        let (lanes, reported) = (info.subgroup_min_size, adapter.cooperative_matrix_properties());
        let fits = |shape: &Self| {
            shape.is_reported(&reported)
                && shape.lanes == info.subgroup_max_size
                && adapter.features().contains(shape.features())
        };
        let halves = [16, 8].map(|side| Self { side, factor: Factor::F16, lanes });
        let exact = Self { side: 8, factor: Factor::F32, lanes };
        let exact = (precision == Precision::F32).then_some(exact);
        exact.into_iter().chain(halves).find(fits)
    }

    /// Device features that this shape needs.
    #[must_use]
    pub fn features(self) -> wgpu::Features {
        let half = match self.factor {
            Factor::F16 => wgpu::Features::SHADER_F16,
            Factor::F32 => wgpu::Features::empty(),
        };
        wgpu::Features::EXPERIMENTAL_COOPERATIVE_MATRIX | wgpu::Features::SUBGROUP | half
    }

    /// Whether a device can run the kernels: it needs the features, and subgroups of exactly
    /// `lanes` invocations, four per workgroup. Devices do not report the shapes they multiply, so
    /// the caller must take the shape from [`MatrixShape::of`] the device's adapter.
    #[must_use]
    pub fn runs_on(self, device: &wgpu::Device) -> bool {
        let info = device.adapter_info();
        matches!(self.side, 8 | 16)
            && device.features().contains(self.features())
            && [info.subgroup_min_size, info.subgroup_max_size] == [self.lanes; 2]
            && self.lanes * SUBGROUPS <= device.limits().max_compute_invocations_per_workgroup
    }

    fn is_reported(self, reported: &[wgpu::CooperativeMatrixProperties]) -> bool {
        use wgpu::CooperativeScalarType::{F16, F32};
        let factor = if self.factor == Factor::F16 { F16 } else { F32 };
        reported.iter().any(|p| {
            [p.m_size, p.n_size, p.k_size] == [self.side; 3]
                && (p.ab_type, p.cr_type) == (factor, F32)
        })
    }

    pub(crate) fn wgsl_type(self) -> &'static str {
        match self.factor {
            Factor::F16 => "f16",
            Factor::F32 => "f32",
        }
    }
}
