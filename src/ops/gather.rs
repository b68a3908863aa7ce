//! The result of a kernel pyramid: at each level, the sum of 3×3 pixels weighted by the softmax of
//! the logits, plus the coarser result. The last call stores the image.
//!
//! The softmax kernels follow Bako et al., "Kernel-Predicting Convolutional Networks for Denoising
//! Monte Carlo Renderings" (2017).

use std::borrow::Cow;

use super::activity::Activity;
use super::contrast::{Contrast, demodulating};
use super::head;
use super::image::{ImageFormat, result_features};
use super::output_process::{ResultImages, result_bindings};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::shader::ShaderRoot;

/// Pixels of a row per invocation.
const PIXELS: u32 = 4;

/// The kernel for a level that has a coarser one.
pub const LEVEL: KernelSpec = KernelSpec {
    name: Cow::Borrowed("gather"),
    source: ShaderRoot::Module("gather"),
    features: Cow::Borrowed(&["gather"]),
    entry: "main",
    bindings: Cow::Borrowed(&[
        Binding::LightIn,
        Binding::TensorIn,
        Binding::LightOut,
        Binding::LightIn,
    ]),
    overrides: &[],
    workgroup: [8, 8, 1],
};

/// The kernel for the coarsest level.
pub const BOTTOM: KernelSpec = KernelSpec {
    name: Cow::Borrowed("gather_bottom"),
    features: Cow::Borrowed(&["gather", "bottom"]),
    bindings: Cow::Borrowed(&[Binding::LightIn, Binding::TensorIn, Binding::LightOut]),
    ..LEVEL
};

/// The kernel for the albedo at full resolution, which stores the contrast.
pub const ALBEDO: KernelSpec = KernelSpec {
    name: Cow::Borrowed("gather_albedo"),
    features: Cow::Borrowed(&["gather", "stores_contrast"]),
    bindings: Cow::Borrowed(&[
        Binding::LightIn,
        Binding::TensorIn,
        Binding::TensorOut,
        Binding::LightIn,
    ]),
    ..LEVEL
};

/// The overrides of the kernel that repairs the color itself.
const OVERRIDES: &[&str] = &["brightest", "outlier", "transfer_function"];

/// Where the kernel that stores the image gets level 0 of the pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level0 {
    /// It computes the level from the noisy color.
    Computed,
    /// It reads the level.
    Stored,
    /// It reads the level, which belongs to a further layer of the image.
    OfLayer,
}

/// The kernel that stores the image, for noisy color and result in these formats.
#[must_use]
pub fn finest_spec(color: ImageFormat, output: ImageFormat, level0: Level0) -> KernelSpec {
    let (name, feature) = match level0 {
        Level0::Computed => ("gather_finest", [].as_slice()),
        Level0::Stored => ("gather_stored", ["stored_finest"].as_slice()),
        Level0::OfLayer => ("gather_layer", ["stored_finest", "layer"].as_slice()),
    };
    let mut features = result_features(color, output);
    features.extend(["gather", "finest"].iter().chain(feature));
    let stored = level0 != Level0::Computed;
    let mut bindings = result_bindings(color, output);
    bindings.extend([Binding::Buffer, Binding::TensorIn, Binding::LightIn]);
    bindings.extend(stored.then_some(Binding::LightIn));
    KernelSpec {
        name: head::name(name, color, output).into(),
        features: features.into(),
        bindings: bindings.into(),
        overrides: if stored { &["brightest", "transfer_function"] } else { OVERRIDES },
        ..LEVEL
    }
}

/// The call that computes a level's result from the pyramid's level, its logits and the coarser
/// result, if there is a coarser level.
#[must_use]
pub fn gather(
    context: &Context,
    [level, logits]: [&GpuTensor; 2],
    coarser: Option<&GpuTensor>,
    output: &GpuTensor,
) -> Dispatch {
    let kernel = context.kernel(if coarser.is_some() { &LEVEL } else { &BOTTOM }, &[]);
    let tensors = [level, logits, output].into_iter().chain(coarser);
    let resources: Vec<_> = tensors.map(GpuTensor::resource).collect();
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width.div_ceil(PIXELS), output.height, 1])
}

/// The call that stores the albedo's contrast, from level 0 of its pyramid, the logits of full
/// resolution and the result of level 1. In blocks that skip the network, the contrast is undefined
/// and never read.
#[must_use]
pub fn gather_albedo(
    context: &Context,
    [level0, logits]: [&GpuTensor; 2],
    coarser: &GpuTensor,
    output: &Contrast,
) -> Dispatch {
    let kernel = context.kernel(&ALBEDO, &[]);
    let resources = [level0, logits, &output.tensor, coarser].map(GpuTensor::resource);
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [logits.width.div_ceil(PIXELS), logits.height, 1])
}

/// The call that stores the image from the noisy color, the logits of full resolution and the
/// result of level 1, plus level 0 of the pyramid if it is stored and the albedo's contrast if the
/// network demodulates. Clean blocks keep their input. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn gather_finest(
    context: &Context,
    tensors: [&GpuTensor; 2],
    level0: Option<&GpuTensor>,
    contrast: Option<&Contrast>,
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Dispatch {
    let kind = if level0.is_some() { Level0::Stored } else { Level0::Computed };
    store(context, (kind, level0), tensors, contrast, activity, images)
}

/// The call that stores the result of a further layer, which is the color of `images`. Clean blocks
/// keep level 0. [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn gather_layer(
    context: &Context,
    tensors: [&GpuTensor; 2],
    level0: &GpuTensor,
    contrast: Option<&Contrast>,
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Dispatch {
    store(context, (Level0::OfLayer, Some(level0)), tensors, contrast, activity, images)
}

fn store(
    context: &Context,
    (kind, level0): (Level0, Option<&GpuTensor>),
    [logits, coarser]: [&GpuTensor; 2],
    contrast: Option<&Contrast>,
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Dispatch {
    let spec = finest_spec(images.color.format(), images.output.format(), kind);
    let spec = if contrast.is_some() { demodulating(spec) } else { spec };
    let kernel = context.kernel(&spec, &images.encoding.constants());
    let mut resources = images.resources();
    resources.push(activity.clean.as_entire_binding());
    resources.extend([logits.resource(), coarser.resource()]);
    resources.extend(level0.map(GpuTensor::resource));
    resources.extend(contrast.map(Contrast::resource));
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [logits.width.div_ceil(PIXELS), logits.height, 1])
}
