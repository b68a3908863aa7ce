//! The pyramid of the noisy color, and of the albedo, that a kernel pyramid averages: each level is
//! the mean of 2×2 weighted pixels of the finer one, times its own confidence.
//!
//! A pixel is a color, its weight and, with [demodulation](super::demodulation), an albedo, in
//! 32-bit floats. A level has an albedo if its tensor has two quads.
//!
//! After Vogels et al., "Denoising with Kernel
//! Prediction and Asymmetric Loss Functions" (2018), and Bálint et al., "Neural Partitioning
//! Pyramids for Denoising Monte Carlo Renderings" (2023), whose levels are plain means.

use std::borrow::Cow;

use super::demodulation::{for_levels, reading_albedo};
use super::image::{ImageBinding, ImageFormat, beauty_features, color_features};
use super::input_process::{TILE, scale_binding, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::model::Encoding;
use crate::shader::ShaderRoot;

/// The kernel that computes a level from the finer one.
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
    spec("level0", color, &[])
}

/// The kernel that computes level 1 from noisy color in this format, without storing level 0.
#[must_use]
pub fn finest_spec(color: ImageFormat) -> KernelSpec {
    spec("finest", color, &[Binding::TensorIn])
}

/// The kernel that stores level 0 of a further layer of the image, for layer and beauty in these
/// formats.
#[must_use]
pub fn layer0_spec(layer: ImageFormat, beauty: ImageFormat) -> KernelSpec {
    let mut spec = spec("level0", layer, &[beauty.source_binding()]);
    spec.features.to_mut().extend(beauty_features(beauty));
    let formats = [layer, beauty].map(ImageFormat::source_name).join(" ");
    KernelSpec { name: format!("pyramid_layer0 {formats}").into(), ..spec }
}

/// A kernel that reads noisy color, with `further` bindings after the scale.
fn spec(feature: &'static str, color: ImageFormat, further: &[Binding]) -> KernelSpec {
    let mut features = color_features(color);
    features.push(feature);
    let (logits, output) = (Binding::TensorIn, Binding::LightOut);
    let mut bindings = vec![TILE, color.source_binding(), logits, output, Binding::Buffer];
    bindings.extend(further);
    KernelSpec {
        name: format!("pyramid_{feature} {}", color.source_name()).into(),
        features: features.into(),
        bindings: bindings.into(),
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
    /// The albedo, if the network demodulates.
    pub albedo: Option<ImageBinding<'a>>,
    /// The 32-bit float that brings color to the network's exposure; the outlier limit depends on
    /// it.
    pub input_scale: &'a wgpu::Buffer,
    /// Decides how the color is repaired.
    pub encoding: Encoding,
}

/// The call that stores level 0, with an albedo if `noisy` has one. [`Dispatch::record_at`] selects
/// the tile.
#[must_use]
pub fn pyramid_level0(
    context: &Context,
    noisy: &NoisyColor<'_>,
    logits: &GpuTensor,
    output: &GpuTensor,
) -> Dispatch {
    let spec = level0_spec(noisy.color.format());
    from_color(context, spec, noisy, [logits, output], None)
}

/// The call that stores level 0 of the layer `noisy.color`, without an albedo, of an image whose
/// color is `beauty`. The layer is repaired like `beauty`. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn pyramid_layer0(
    context: &Context,
    noisy: &NoisyColor<'_>,
    beauty: ImageBinding<'_>,
    logits: &GpuTensor,
    output: &GpuTensor,
) -> Dispatch {
    let spec = layer0_spec(noisy.color.format(), beauty.format());
    let noisy = &NoisyColor { albedo: None, ..*noisy };
    from_color(context, spec, noisy, [logits, output], Some(beauty.resource()))
}

/// The call that computes level 1 without a stored level 0. `finest` and `logits` are the logits of
/// levels 0 and 1. The level has an albedo if `noisy` has one. [`Dispatch::record_at`] selects the
/// tile.
#[must_use]
pub fn pyramid_finest(
    context: &Context,
    noisy: &NoisyColor<'_>,
    [finest, logits]: [&GpuTensor; 2],
    output: &GpuTensor,
) -> Dispatch {
    let spec = finest_spec(noisy.color.format());
    from_color(context, spec, noisy, [logits, output], Some(finest.resource()))
}

fn from_color(
    context: &Context,
    spec: KernelSpec,
    noisy: &NoisyColor<'_>,
    [logits, output]: [&GpuTensor; 2],
    further: Option<wgpu::BindingResource<'_>>,
) -> Dispatch {
    let spec = match noisy.albedo {
        Some(albedo) => reading_albedo(spec, albedo.format()),
        None => spec,
    };
    let kernel = context.kernel(&spec, &noisy.encoding.constants());
    let mut resources = vec![
        tile_binding(noisy.tiles),
        noisy.color.resource(),
        logits.resource(),
        output.resource(),
        scale_binding(noisy.input_scale),
    ];
    resources.extend(further);
    resources.extend(noisy.albedo.map(|albedo| albedo.resource()));
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
    let kernel = context.kernel(&for_levels(&LEVEL, output), &[]);
    let resources = [finer, logits, output].map(GpuTensor::resource);
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width, output.height, 1])
}
