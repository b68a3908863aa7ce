//! What can change from frame to frame: the blend, and the caller's exposure.

use wgdenoise::{Image, InputScale, Inputs, KernelSet, Layout, Options, Precision};

use super::{F32, Scene};
use crate::support::{denoiser, frame, images, run, same_bits};
use wgdenoise_testing::gpu::{buffer, context, kernel_sets};
use wgdenoise_testing::image::cpu_image;
use wgdenoise_testing::{Tolerance, compare, image_tensor, run_cases};

/// Two products and a sum, each rounded once.
const TOLERANCE: Tolerance = Tolerance { absolute: 1e-12, relative: 4.0 * f32::EPSILON };

#[test]
fn the_result_is_a_mixture_of_the_denoised_and_the_noisy_color() {
    let mut images = images(50, 40);
    images[0].pixels_mut()[60] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let frame = frame(&images, Inputs::ALL);
    let shares = [0.0, 0.25, 0.9, 1.0];
    let sets = kernel_sets(Precision::F32);
    let cases = sets.iter().flat_map(|&set| shares.map(|share| (set, share)));
    run_cases(cases, |&(kernels, share)| {
        let options = Options::default().kernels(kernels).precision(Precision::F32);
        let scene = Scene::new(&frame, F32, Layout::packed(50));
        let denoiser = denoiser(&options);
        let pass = denoiser.pass(&scene.descriptor()).expect("the images fit");
        pass.set_blend(share);
        let found = cpu_image(&scene.output.read(|encoder| pass.encode(encoder)), [50, 40]);
        let expected = mixture(&run(&options, &frame), frame.color, share);
        compare(&image_tensor(&found), &image_tensor(&expected), TOLERANCE)?;
        if share == 1.0 { same_numbers(&found, frame.color) } else { Ok(()) }
    });
}

fn mixture(denoised: &Image, noisy: &Image, share: f32) -> Image {
    let mut mixture = denoised.clone();
    for (pixel, noisy) in mixture.pixels_mut().iter_mut().zip(noisy.pixels()) {
        *pixel = [0, 1, 2].map(|c| wgdenoise_testing::pixels::blend(pixel[c], noisy[c], share));
    }
    mixture
}

/// At full blend, nothing of the network remains, not even its bias.
fn same_numbers(found: &Image, noisy: &Image) -> Result<(), String> {
    let pairs = found.pixels().iter().flatten().zip(noisy.pixels().iter().flatten());
    match pairs.filter(|(found, noisy)| noisy.is_finite() && found != noisy).count() {
        0 => Ok(()),
        count => Err(format!("{count} values are not the noisy ones")),
    }
}

#[test]
fn a_blend_beyond_what_it_can_be_is_clamped() {
    let images = images(16, 16);
    let scene = Scene::new(&frame(&images, Inputs::default()), F32, Layout::packed_rgba(16));
    let pass = denoiser(&Options::default()).pass(&scene.descriptor()).expect("the images fit");
    let run = |share| {
        pass.set_blend(share);
        scene.output.read(|encoder| pass.encode(encoder))
    };
    let (nothing, all) = (run(0.0), run(1.0));
    assert_ne!(nothing, all);
    assert!(run(1.5) == all && run(f32::INFINITY) == all);
    assert!(run(-1.0) == nothing && run(f32::NAN) == nothing);
}

#[test]
fn the_exposure_may_come_from_a_buffer_that_changes() {
    let images = images(50, 40);
    let queue = &context(Precision::F32).queue;
    let scale = buffer(context(Precision::F32), bytemuck::bytes_of(&0.3_f32));
    let scene = Scene::new(&frame(&images, Inputs::ALL), F32, Layout::packed(50));
    let descriptor = scene.descriptor().input_scale(InputScale::Buffer(&scale));
    let denoiser = denoiser(&Options::default().kernels(KernelSet::Auto));
    let pass = denoiser.pass(&descriptor).unwrap();
    for value in [0.3_f32, 2.0] {
        queue.write_buffer(&scale, 0, bytemuck::bytes_of(&value));
        let found = cpu_image(&scene.output.read(|encoder| pass.encode(encoder)), [50, 40]);
        let frame = frame(&images, Inputs::ALL).input_scale(value);
        same_bits(&found, &run(&Options::default(), &frame)).unwrap();
    }
}
