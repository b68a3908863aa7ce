//! The pyramid of the noisy color that a kernel pyramid averages: each level is the sum of 2×2
//! pixels of the finer one, times its own confidence.
//!
//! A pixel is a color and its weight, in 32-bit floats. After Vogels et al., "Denoising with Kernel
//! Prediction and Asymmetric Loss Functions" (2018), and Bálint et al., "Neural Partitioning
//! Pyramids for Denoising Monte Carlo Renderings" (2023), whose levels are plain means.

use std::borrow::Cow;

use super::image::{ImageBinding, ImageFormat, color_features};
use super::input_process::{TILE, scale_binding, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::model::Encoding;
use crate::shader::ShaderRoot;

/// The kernel for a level from the finer level.
pub const LEVEL: KernelSpec = KernelSpec {
    name: Cow::Borrowed("pyramid"),
    source: ShaderRoot::Module("pyramid"),
    features: Cow::Borrowed(&[]),
    entry: "main",
    bindings: Cow::Borrowed(&[Binding::LightIn, Binding::TensorIn, Binding::LightOut]),
    overrides: &[],
    workgroup: [8, 8, 1],
};

/// The kernel that stores level 0 from noisy color in this format.
#[must_use]
pub fn level0_spec(color: ImageFormat) -> KernelSpec {
    let mut features = color_features(color);
    features.push("level0");
    let (logits, image) = (Binding::TensorIn, color.source_binding());
    KernelSpec {
        name: format!("pyramid_level0 {}", color.source_name()).into(),
        features: features.into(),
        bindings: vec![TILE, image, logits, Binding::LightOut, Binding::Buffer].into(),
        overrides: &["brightest", "outlier", "transfer_function"],
        ..LEVEL
    }
}

/// The kernel for level 1 from noisy color in this format, whose level 0 is not stored.
#[must_use]
pub fn finest_spec(color: ImageFormat) -> KernelSpec {
    let mut features = color_features(color);
    features.push("finest");
    let (logits, image) = (Binding::TensorIn, color.source_binding());
    KernelSpec {
        name: format!("pyramid_finest {}", color.source_name()).into(),
        features: features.into(),
        bindings: vec![TILE, image, logits, Binding::LightOut, Binding::Buffer, logits].into(),
        overrides: &["brightest", "outlier", "transfer_function"],
        ..LEVEL
    }
}

/// The noisy color, and how to read it.
#[derive(Clone, Copy, Debug)]
pub struct NoisyColor<'a> {
    /// [`Tile`](super::tile::Tile)s, one at each dynamic offset.
    pub tiles: &'a wgpu::Buffer,
    /// The color.
    pub color: ImageBinding<'a>,
    /// The 32-bit float that brings color to the network's exposure, which decides what an outlier
    /// is.
    pub input_scale: &'a wgpu::Buffer,
    /// Decides how the color is repaired.
    pub encoding: Encoding,
}

/// The call that stores level 0. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn pyramid_level0(
    context: &Context,
    noisy: &NoisyColor<'_>,
    logits: &GpuTensor,
    output: &GpuTensor,
) -> Dispatch {
    let spec = level0_spec(noisy.color.format());
    let kernel = context.kernel(&spec, &noisy.encoding.constants());
    let resources = [
        tile_binding(noisy.tiles),
        noisy.color.resource(),
        logits.resource(),
        output.resource(),
        scale_binding(noisy.input_scale),
    ];
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width, output.height, 1])
}

/// The call that computes level 1 where level 0 is not stored. `finest` and `logits` are the logits of level 0 and of this one.
/// [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn pyramid_finest(
    context: &Context,
    noisy: &NoisyColor<'_>,
    [finest, logits]: [&GpuTensor; 2],
    output: &GpuTensor,
) -> Dispatch {
    let spec = finest_spec(noisy.color.format());
    let kernel = context.kernel(&spec, &noisy.encoding.constants());
    let resources = [
        tile_binding(noisy.tiles),
        noisy.color.resource(),
        logits.resource(),
        output.resource(),
        scale_binding(noisy.input_scale),
        finest.resource(),
    ];
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width, output.height, 1])
}

/// The call that computes a level from the finer one and the level's logits.
#[must_use]
pub fn pyramid(
    context: &Context,
    finer: &GpuTensor,
    logits: &GpuTensor,
    output: &GpuTensor,
) -> Dispatch {
    let kernel = context.kernel(&LEVEL, &[]);
    let resources = [finer, logits, output].map(GpuTensor::resource);
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width, output.height, 1])
}
