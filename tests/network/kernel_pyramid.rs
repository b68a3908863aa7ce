//! Guarantees of a kernel pyramid with any weights.

use proptest::prelude::*;
use wgdenoise::{Frame, Image, Inputs, KernelSet, Options, Precision};

use crate::support::{denoiser_of, frame, images, same_bits, tiny_kernels};
use wgdenoise_testing::gpu::{fused_sets, kernel_sets, variants};
use wgdenoise_testing::run_cases;

fn run(options: &Options, frame: &Frame<'_>) -> Image {
    denoiser_of(&tiny_kernels(), options).denoise(frame).expect("the frame is fine")
}

/// Disables skipping, so that the network processes every pixel.
fn every_pixel(kernels: KernelSet, precision: Precision) -> Options {
    Options::default().kernels(kernels).precision(precision).skip_clean(false)
}

#[test]
fn a_constant_of_any_hue_and_brightness_stays_bit_for_bit() {
    let [_, albedo, normal] = images(41, 23);
    let colors = [[0.0; 3], [1e-12, 0.0, 0.0], [0.0, 3.3, 1e-5], [65504.0; 3], [1e12, 7.7, 0.1]];
    run_cases(variants(), |&(kernels, precision)| {
        for color in colors {
            let image = Image::filled(41, 23, color).expect("a valid image");
            let frame = Frame::new(&image).albedo(&albedo).normal(&normal);
            let found = run(&every_pixel(kernels, precision), &frame);
            if found != image {
                return Err(format!("{color:?} became {:?}", found.pixels()[100]));
            }
        }
        Ok(())
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// The exposed input is the same, hence the kernel weights too, so light scales exactly.
    #[test]
    fn a_gain_of_a_power_of_two_changes_no_bit_but_the_exponent(power in -40_i32..40) {
        let images = images(37, 22);
        let gain = 2_f32.powi(power);
        let mut bright = images.clone();
        bright[0].pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v * gain));
        let options = Options::default().precision(Precision::F32);
        let found = run(&options, &frame(&bright, Inputs::ALL).input_scale(0.5 / gain));
        let expected = run(&options, &frame(&images, Inputs::ALL).input_scale(0.5));
        for (found, expected) in found.pixels().iter().zip(expected.pixels()) {
            prop_assert_eq!(*found, expected.map(|v| v * gain));
        }
    }
}

/// A constant's result is the same constant, so skipping it changes nothing.
#[test]
fn skipping_constant_blocks_changes_no_bit() {
    let [noise, albedo, normal] = images(320, 208);
    let mut color = noise;
    for (i, pixel) in color.pixels_mut().iter_mut().enumerate() {
        let [x, y] = [i % 320, i / 320].map(|at| at as f64);
        if (x - 60.0).hypot(y - 50.0) > 40.0 {
            *pixel = if x < 200.0 { [0.3, 7.7, 1e-3] } else { [0.0; 3] };
        }
    }
    let images = [color, albedo, normal];
    run_cases(fused_sets(Precision::F16), |&kernels| {
        let frame = frame(&images, Inputs::ALL);
        let skipping = run(&Options::default().kernels(kernels), &frame);
        same_bits(&skipping, &run(&every_pixel(kernels, Precision::F16), &frame))
    });
}

#[test]
fn no_result_is_darker_or_brighter_than_the_noisy_color() {
    let images = images(64, 48);
    run_cases(kernel_sets(Precision::F16), |&kernels| {
        let found = run(&every_pixel(kernels, Precision::F16), &frame(&images, Inputs::ALL));
        for c in 0..3 {
            let of = |image: &Image, f: fn(f32, f32) -> f32| {
                image.pixels().iter().map(|pixel| pixel[c]).reduce(f).expect("there are pixels")
            };
            let [least, most] = [of(&images[0], f32::min), of(&images[0], f32::max)];
            if of(&found, f32::min) < least || of(&found, f32::max) > most {
                return Err(format!("channel {c} leaves {least} to {most}"));
            }
        }
        Ok(())
    });
}
