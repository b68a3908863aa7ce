//! The result of a kernel pyramid: at each level, the sum of 3×3 pixels weighted by the softmax of
//! the logits, plus the coarser result. The last call stores the image.
//!
//! The softmax kernels follow Bako et al., "Kernel-Predicting Convolutional Networks for Denoising
//! Monte Carlo Renderings" (2017).

use std::borrow::Cow;

use super::activity::Activity;
use super::demodulation::{for_levels, reading_albedo};
use super::head;
use super::image::{ImageBinding, ImageFormat, result_features};
use super::output_process::{ResultImages, result_bindings};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::gpu::tensor::GpuTensor;
use crate::shader::ShaderRoot;

/// Pixels of a row per invocation.
pub const PIXELS: u32 = 4;

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

/// Level 0 of the pyramid, for the call that stores the image.
#[derive(Clone, Copy, Debug)]
pub enum Level0<'a> {
    /// The call computes it from the noisy color and, to demodulate, from this albedo.
    Computed(Option<ImageBinding<'a>>),
    /// The call reads it.
    Stored(&'a GpuTensor),
    /// The call reads it; it belongs to a further layer of the image.
    OfLayer(&'a GpuTensor),
}

/// The kernel that computes level 0 and stores the image, for noisy color and result in these
/// formats.
#[must_use]
pub fn computed_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    let mut spec = storing_spec("gather_finest", color, output, &[]);
    // It repairs the color itself.
    spec.overrides = &["brightest", "outlier", "transfer_function"];
    spec
}

/// The kernel that reads level 0 and stores the image, for noisy color and result in these formats.
#[must_use]
pub fn stored_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    storing_spec("gather_stored", color, output, &["stored_finest"])
}

/// The same for a further layer of the image.
#[must_use]
pub fn layer_spec(color: ImageFormat, output: ImageFormat) -> KernelSpec {
    storing_spec("gather_layer", color, output, &["stored_finest", "layer"])
}

fn storing_spec(
    name: &str,
    color: ImageFormat,
    output: ImageFormat,
    level0: &[&'static str],
) -> KernelSpec {
    let mut features = result_features(color, output);
    features.extend(["gather", "finest"].iter().chain(level0));
    let mut bindings = result_bindings(color, output);
    bindings.extend([Binding::Buffer, Binding::TensorIn, Binding::LightIn]);
    bindings.extend((!level0.is_empty()).then_some(Binding::LightIn));
    KernelSpec {
        name: head::name(name, color, output).into(),
        features: features.into(),
        bindings: bindings.into(),
        overrides: &["brightest", "transfer_function"],
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
    let spec = if coarser.is_some() { LEVEL } else { BOTTOM };
    let kernel = context.kernel(&for_levels(&spec, output), &[]);
    let tensors = [level, logits, output].into_iter().chain(coarser);
    let resources: Vec<_> = tensors.map(GpuTensor::resource).collect();
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [output.width.div_ceil(PIXELS), output.height, 1])
}

/// The call that stores the image, or a further layer that is the color of `images`, from level 0,
/// the logits of full resolution and the result of level 1. If that result has an albedo, the image
/// is demodulated, and level 0 must have one too. Clean blocks keep their input.
/// [`Dispatch::record_at`] selects the tile.
#[must_use]
pub fn gather_finest(
    context: &Context,
    level0: Level0<'_>,
    [logits, coarser]: [&GpuTensor; 2],
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Dispatch {
    let (color, output) = (images.color.format(), images.output.format());
    let (spec, last) = match level0 {
        Level0::Computed(None) => (computed_spec(color, output), None),
        Level0::Computed(Some(albedo)) => {
            let spec = reading_albedo(computed_spec(color, output), albedo.format());
            (spec, Some(albedo.resource()))
        }
        Level0::Stored(level) => {
            (for_levels(&stored_spec(color, output), coarser), Some(level.resource()))
        }
        Level0::OfLayer(level) => {
            (for_levels(&layer_spec(color, output), coarser), Some(level.resource()))
        }
    };
    let kernel = context.kernel(&spec, &images.encoding.constants());
    let mut resources = images.resources();
    resources.push(activity.clean.as_entire_binding());
    resources.extend([logits.resource(), coarser.resource()]);
    resources.extend(last);
    let group = kernel.bind(&context.device, &resources);
    kernel.dispatch(group, [logits.width.div_ceil(PIXELS), logits.height, 1])
}
