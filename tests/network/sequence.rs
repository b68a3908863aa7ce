//! Frames in a row: what an earlier frame leaves in memory changes no later one.

use wgdenoise::{Denoiser, Frame, Image, Inputs, Options, Weights};

use crate::support::{
    denoiser_of, frame, images, same_bits, tiny, tiny_demodulation, tiny_kernels,
};
use wgdenoise_testing::gpu::variants;
use wgdenoise_testing::run_cases;

/// Color and layers of a frame.
fn denoised(denoiser: &Denoiser, frame: &Frame<'_>) -> Vec<Image> {
    let found = denoiser.denoise_layers(frame, &mut |_| {}).expect("the frame is fine");
    [found.color].into_iter().chain(found.layers).collect()
}

/// The images, black but for the left quarter, so that most blocks skip the network.
fn mostly_black(images: &[Image; 3]) -> [Image; 3] {
    let width = images[0].width();
    images.clone().map(|mut image| {
        for (x, pixel) in (0..width).cycle().zip(image.pixels_mut()) {
            if x >= width / 4 {
                *pixel = [0.0; 3];
            }
        }
        image
    })
}

/// Frames of one size that differ in their light, exposure and inputs.
fn sequence(images: [&[Image; 3]; 3]) -> Vec<Frame<'_>> {
    let [noisy, dark, bright] = images;
    vec![
        frame(noisy, Inputs::ALL),
        frame(dark, Inputs::ALL),
        frame(bright, Inputs::ALL),
        frame(noisy, Inputs::ALL).input_scale(2.0),
        frame(noisy, Inputs::ALL),
        frame(dark, Inputs::default()),
        frame(noisy, Inputs::default()),
    ]
}

/// Compares each frame after the earlier ones with the same frame in new memory.
fn check(weights: &Weights, options: &Options, frames: &[Frame<'_>]) -> Result<(), String> {
    let keeping = denoiser_of(weights, options);
    let freeing = denoiser_of(weights, &options.clone().keep_memory(false));
    for (i, frame) in frames.iter().enumerate() {
        for (found, expected) in denoised(&keeping, frame).iter().zip(&denoised(&freeing, frame)) {
            same_bits(found, expected).map_err(|error| format!("frame {i}: {error}"))?;
        }
    }
    Ok(())
}

#[test]
fn every_frame_of_a_sequence_equals_the_same_frame_in_new_memory() {
    let noisy = images(150, 90);
    let dark = mostly_black(&noisy);
    let mut bright = noisy.clone();
    bright[0].pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v * 64.0));
    let frames = sequence([&noisy, &dark, &bright]);
    let layers = [&noisy[1], &noisy[0]];
    let with_layers: Vec<_> = frames.iter().map(|frame| frame.layers(&layers)).collect();
    run_cases(variants(), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        check(&tiny(), &options, &frames)?;
        check(&tiny_kernels(), &options, &with_layers)?;
        let tiled = options.tile(144);
        check(&tiny_demodulation(), &tiled, &with_layers)
    });
}
