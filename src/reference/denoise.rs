//! Denoises a whole frame: see [`denoise`].

use super::input_process::input_process_in;
use super::kernel_pyramid::kernel_pyramid;
use super::network::{apply, run_by};
use super::output_process::output_process_in;
use super::repair::{Repaired, repair_in};
use super::tensor::Tensor;
use crate::image::Image;
use crate::model::{Op, Params, Weights};

/// The images of a frame, all of one size.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    /// Noisy color.
    pub color: &'a Image,
    /// Albedo, if given.
    pub albedo: Option<&'a Image>,
    /// Normal, if given.
    pub normal: Option<&'a Image>,
}

/// Denoises a frame, from pixels to pixels. The weights must be [for the
/// inputs](Weights::for_inputs) that the frame has.
///
/// # Panics
/// Panics if the images differ in size.
#[must_use]
pub fn denoise(weights: &Weights, images: Images<'_>, input_scale: f32) -> Image {
    denoise_by(weights, images, input_scale, apply)
}

/// [`denoise`] with every layer computed by `apply`.
///
/// # Panics
/// Panics like [`denoise`].
#[must_use]
pub fn denoise_by(
    weights: &Weights,
    images: Images<'_>,
    input_scale: f32,
    apply: impl Fn(Op, &Params, &[&Tensor]) -> Tensor,
) -> Image {
    let (color, encoding) = (images.color, weights.metadata().encoding());
    let (outputs, albedo) = predicted_by(weights, images, input_scale, apply);
    if weights.network().has_pyramid() {
        let Repaired { color, valid } = repair_in(encoding, color, input_scale);
        return kernel_pyramid(&outputs, &color, &valid, albedo.as_ref());
    }
    output_process_in(encoding, &outputs[0], input_scale, color.width(), color.height())
}

/// The network's outputs for a frame, and the albedo that it reads, if it demodulates.
pub(super) type Predicted = (Vec<Tensor>, Option<Image>);

/// Runs the network on a frame.
pub(super) fn predicted(weights: &Weights, images: Images<'_>, input_scale: f32) -> Predicted {
    predicted_by(weights, images, input_scale, apply)
}

fn predicted_by(
    weights: &Weights,
    Images { color, albedo, normal }: Images<'_>,
    input_scale: f32,
    apply: impl Fn(Op, &Params, &[&Tensor]) -> Tensor,
) -> Predicted {
    let (encoding, network) = (weights.metadata().encoding(), weights.network());
    let alignment = network.alignment().max(16);
    let input = input_process_in(encoding, color, albedo, normal, input_scale, alignment);
    let albedo = albedo.filter(|_| network.demodulates()).map(|albedo| {
        let pixel = |i: usize| {
            let (x, y) = (i % albedo.width() as usize, i / albedo.width() as usize);
            [3, 4, 5].map(|c| input.at(c, y, x))
        };
        let pixels = (0..albedo.pixels().len()).map(pixel).collect();
        Image::new(albedo.width(), albedo.height(), pixels).expect("the size is the albedo's")
    });
    (run_by(network, |layer| weights.params(layer), &input, apply), albedo)
}
