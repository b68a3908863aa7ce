//! The denoisers of the hard cases: the GPU engine and the CPU reference.

use wgdenoise::Rect;
use wgdenoise::internals::plan::halo::constant_radius;
use wgdenoise::internals::reference::{self, Images, TileOfImage};
use wgdenoise::{Denoiser, Frame, Gpu, Image, Inputs, KernelSet, Options, Precision, Weights};

/// Creates the engine on the first adapter, with tiles of at most `tile` pixels per side.
pub fn engine(
    gpu: &Gpu,
    weights: &Weights,
    precision: Precision,
    tile: Option<u32>,
) -> impl Fn(&Image) -> Image + use<> {
    engine_with(gpu, weights, &Options::default().precision(precision).tile(tile))
}

/// Creates the engine on the first adapter, in 16-bit arithmetic.
pub fn half_engine(gpu: &Gpu, weights: &Weights) -> impl Fn(&Image) -> Image + use<> {
    engine_with(gpu, weights, &Options::default().kernels(KernelSet::Half))
}

fn engine_with(
    gpu: &Gpu,
    weights: &Weights,
    options: &Options,
) -> impl Fn(&Image) -> Image + use<> {
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, weights, options);
    let denoiser = denoiser.expect("the device works");
    move |color| denoiser.denoise(&Frame::new(color)).expect("the image is fine")
}

/// Runs the CPU reference on an image.
pub fn on_cpu(weights: &Weights, color: &Image) -> Image {
    let (width, height) = color.size();
    let weights = weights.for_inputs(Inputs::default()).expect("the inputs are known");
    let scale = reference::autoexposure(color);
    let images = Images { color, albedo: None, normal: None };
    let result = reference::denoise(&weights, images, scale);
    let radius = constant_radius(weights.network());
    let sides = [width, height].map(|side| side.next_multiple_of(16));
    let clean = clean_blocks(color, radius, sides);
    reference::keep_clean(result, color, &clean, sides[0] as usize / 16)
}

fn clean_blocks(color: &Image, radius: u32, size: [u32; 2]) -> Vec<bool> {
    let (width, height) = color.size();
    let stores = Rect { begin: [0, 0], end: [width, height] };
    let tile = TileOfImage { origin: [0, 0], size, stores };
    reference::activity(color, &tile, 1, Some(radius)).clean
}
