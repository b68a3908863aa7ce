//! A small network, frames for it, and the reference's results.

use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Denoiser, Frame, Image, Inputs, KernelSet, Options, Precision, Weights};

use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::{Random, Tolerance, image_tensor};

/// A network with three widths (two poolings, alignment 4), nine inputs and unfolded batch norms.
pub(crate) fn tiny() -> Weights {
    let bytes = include_bytes!("../fixtures/unet_tiny.safetensors");
    Weights::from_bytes(bytes).expect("the fixture follows the format")
}

/// A kernel pyramid of the same widths.
pub(crate) fn tiny_kernels() -> Weights {
    let bytes = include_bytes!("../fixtures/kernel_tiny.safetensors");
    Weights::from_bytes(bytes).expect("the fixture follows the format")
}

/// A kernel pyramid of four widths (alignment 8) that demodulates.
pub(crate) fn tiny_demodulation() -> Weights {
    let bytes = include_bytes!("../fixtures/demodulating_tiny.safetensors");
    Weights::from_bytes(bytes).expect("the fixture follows the format")
}

pub(crate) fn denoiser(options: &Options) -> Denoiser {
    denoiser_of(&tiny(), options)
}

pub(crate) fn denoiser_of(weights: &Weights, options: &Options) -> Denoiser {
    let denoiser = Denoiser::new(&gpu().device, &gpu().queue, weights, options);
    let denoiser = denoiser.expect("the device works");
    assert_eq!(denoiser.take_notices(), [""; 0], "what was asked for must run");
    denoiser
}

pub(crate) fn images(width: u32, height: u32) -> [Image; 3] {
    let mut random = Random::new(u64::from(width * 7 + height));
    let mut image = |value: fn(f32) -> f32| {
        let pixels = (0..width * height).map(|_| [0; 3].map(|_| value(random.value())));
        Image::new(width, height, pixels.collect()).expect("the count is right")
    };
    [image(|v| (v * 6.0).exp2()), image(f32::abs), image(|v| v)]
}

pub(crate) fn frame(images: &[Image; 3], inputs: Inputs) -> Frame<'_> {
    Frame::new(&images[0])
        .albedo(inputs.albedo.then_some(&images[1]))
        .normal(inputs.normal.then_some(&images[2]))
}

pub(crate) fn run(options: &Options, frame: &Frame<'_>) -> Image {
    denoiser(options).denoise(frame).expect("the frame is fine")
}

/// The reference result of a frame, as an image.
pub(crate) fn expected(weights: &Weights, frame: &Frame<'_>) -> Image {
    let encoding = weights.metadata().encoding();
    let is_hdr = encoding.transfer_function.is_hdr();
    let measured = || if is_hdr { reference::autoexposure(frame.color) } else { 1.0 };
    let scale = frame.input_scale.unwrap_or_else(measured);
    let weights = weights.for_inputs(frame.inputs()).expect("the inputs are known");
    let Frame { color, albedo, normal, .. } = *frame;
    reference::denoise(&weights, reference::Images { color, albedo, normal }, scale)
}

/// Encodes an image in the transfer domain.
pub(crate) fn encoded(image: &Image, scale: f32) -> Tensor {
    let mut tensor = image_tensor(image);
    let encode = |v: f32| reference::pu(f64::from(v) * f64::from(scale)) as f32;
    tensor.data.iter_mut().for_each(|v| *v = encode(*v));
    tensor
}

/// In the transfer domain, where the network works. Measured 5e-7, plus the exposure's error of up
/// to 5e-5, which shifts the logarithmic curve by 3e-6.
pub(crate) const F32: Tolerance = Tolerance { absolute: 4e-6, relative: 0.0 };
/// Each of twelve stores rounds a value of about 1 by 2⁻¹¹. Measured: 2e-3.
pub(crate) const F16: Tolerance = Tolerance { absolute: 6e-3, relative: 0.0 };
/// A 16-bit sum of a chunk of 36 products is off by √(36/2) times 2⁻¹¹ of its value (see
/// `src/denoiser/verify.rs`), and its store by 2⁻¹¹: in total √19 times as much as the store alone.
pub(crate) const HALF: Tolerance = Tolerance { absolute: 26e-3, relative: 0.0 };

/// The tolerance for a kernel set: 16-bit factors round a layer's input like 16-bit tensors do.
pub(crate) fn tolerance(kernels: KernelSet, precision: Precision) -> Tolerance {
    match (kernels, precision) {
        (KernelSet::Half, _) => HALF,
        (KernelSet::Matrix(_), _) | (_, Precision::F16) => F16,
        _ => F32,
    }
}

pub(crate) const SETS: [Inputs; 4] = [
    Inputs { albedo: false, normal: false },
    Inputs { albedo: true, normal: false },
    Inputs { albedo: false, normal: true },
    Inputs::ALL,
];

pub(crate) fn same_bits(found: &Image, expected: &Image) -> Result<(), String> {
    if found.size() != expected.size() {
        return Err(format!("size {:?}, expected {:?}", found.size(), expected.size()));
    }
    let bits = |image: &Image| -> Vec<[u32; 3]> {
        image.pixels().iter().map(|p| p.map(f32::to_bits)).collect()
    };
    match bits(found).iter().zip(&bits(expected)).position(|(a, b)| a != b) {
        None => Ok(()),
        Some(i) => Err(format!("pixel {i} of {:?} differs", found.size())),
    }
}
