//! One kernel call and its cost.

use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::precision::Precision;
use crate::gpu::tensor::GpuTensor;
use crate::ops::image::ImageBinding;

/// One kernel call of a tile.
#[derive(Debug)]
pub(crate) struct Call {
    /// The layer's name, or the operator's.
    pub(crate) name: String,
    /// Multiply-accumulates.
    pub(crate) macs: f64,
    /// Bytes of the tensors and images it reads and writes, each counted once.
    pub(crate) bytes: f64,
    dispatch: Dispatch,
    /// Whether it reads the tile's uniform, at a dynamic offset.
    per_tile: bool,
}

impl Call {
    pub(super) fn per_tile(name: &str, dispatch: Dispatch) -> Self {
        Self { name: name.into(), macs: 0.0, bytes: 0.0, dispatch, per_tile: true }
    }

    /// A call that is the same for every tile.
    pub(super) fn fixed(name: &str, dispatch: Dispatch) -> Self {
        Self { per_tile: false, ..Self::per_tile(name, dispatch) }
    }

    /// The call with its multiply-accumulates.
    pub(super) fn computing(self, macs: f64) -> Self {
        Self { macs, ..self }
    }

    /// The call with the bytes of the tensors and of the pyramid's levels that it reads and writes.
    pub(super) fn moving(
        self,
        context: &Context,
        tensors: &[&GpuTensor],
        light: &[&GpuTensor],
    ) -> Self {
        let of = |tensors: &[&GpuTensor], precision| -> f64 {
            tensors.iter().map(|tensor| tensor.bytes(precision)).sum()
        };
        Self { bytes: of(tensors, context.precision) + of(light, Precision::F32), ..self }
    }

    /// Adds the bytes of images of `size` pixels each to those of tensors.
    pub(super) fn touching(self, size: [u32; 2], images: &[ImageBinding<'_>]) -> Self {
        let bytes: u32 = images.iter().map(|image| image.format().pixel_bytes()).sum();
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        Self { bytes: self.bytes + pixels * f64::from(bytes), ..self }
    }

    /// Records the call for the tile at byte `offset` of the uniform buffer.
    pub(crate) fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        if self.per_tile {
            self.dispatch.record_at(pass, offset);
        } else {
            self.dispatch.record(pass);
        }
    }
}
