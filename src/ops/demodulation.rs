//! Demodulation: the weights of a kernel pyramid gather the albedo along with the light, and the
//! gathered light is multiplied by the ratio of the pixel's own albedo to the gathered one, raised
//! to a power that the network predicts.
//!
//! At power 1, the result is the ratio of mean light to mean albedo, both gathered with the same
//! weights, times the pixel's own albedo: the ratio estimator of W. G. Cochran, "Sampling
//! Techniques" (1977). Bako et al. demodulate light by the albedo in "Kernel-Predicting
//! Convolutional Networks for Denoising Monte Carlo Renderings" (2017).

use super::image::{ImageFormat, albedo_feature};
use crate::gpu::kernel::KernelSpec;
use crate::gpu::tensor::GpuTensor;

/// Quads of a pyramid's level that has an albedo: the color with its weight, and the albedo.
pub const QUADS: u32 = 2;

/// The variant of a pyramid's kernel whose levels have an albedo.
#[must_use]
pub fn demodulating(mut spec: KernelSpec) -> KernelSpec {
    spec.features.to_mut().push("demodulates");
    KernelSpec { name: format!("{} demodulating", spec.name).into(), ..spec }
}

/// Like [`demodulating`], for a kernel that computes level 0: it binds the albedo, in this format,
/// last.
#[must_use]
pub fn reading_albedo(spec: KernelSpec, albedo: ImageFormat) -> KernelSpec {
    let mut spec = demodulating(spec);
    spec.features.to_mut().extend(albedo_feature(albedo));
    spec.bindings.to_mut().push(albedo.source_binding());
    KernelSpec { name: format!("{} {}", spec.name, albedo.source_name()).into(), ..spec }
}

/// The kernel for levels like this one.
pub(super) fn for_levels(spec: &KernelSpec, level: &GpuTensor) -> KernelSpec {
    if level.quads == QUADS { demodulating(spec.clone()) } else { spec.clone() }
}
