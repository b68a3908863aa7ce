//! What a kernel pyramid guarantees whatever its weights are.

use proptest::prelude::*;
use wgdenoise::{Frame, Image, Inputs, KernelSet, Options, Precision, Quality, Weights};

use crate::support::{denoiser_of, frame, images, same_bits, tiny_kernels};
use wgdenoise_testing::gpu::{fused_sets, kernel_sets, variants};
use wgdenoise_testing::run_cases;

fn run(options: &Options, frame: &Frame<'_>) -> Image {
    denoiser_of(&tiny_kernels(), options).denoise(frame).expect("the frame is fine")
}

/// Without skipping, so that the network works on every pixel.
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
    /// For a given exposure the weights are given too, whatever is in the other channels' light.
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

/// The result of a constant is that constant, so leaving it out changes nothing at all.
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

/// In f16, a network that outputs color ends with a kernel that reads 32 bytes of features per
/// pixel. Here that kernel also stores 12 logits, 24 bytes; the pyramid reads 4 of them and the
/// gather all, with a quarter of a color and its weight: 60 bytes more. The coarser levels move
/// less than that again.
#[test]
fn the_pyramid_moves_60_bytes_per_pixel_and_as_many_at_coarser_levels() {
    let weights = Weights::builtin(Quality::Balanced).expect("it is built in");
    let options = Options::default().kernels(KernelSet::Tiled).precision(Precision::F16);
    let images = images(64, 64);
    let frame = frame(&images, Inputs::ALL);
    let profile = denoiser_of(&weights, &options).profile(&frame, 1).expect("it runs");
    let bytes = |is: fn(&str) -> bool| {
        let calls = profile.iter().filter(|call| is(&call.name));
        calls.map(|call| call.bytes).sum::<f64>() / (64.0 * 64.0)
    };
    let last = bytes(|name| name == "dec_conv0b+kernel_conv0") - 32.0;
    let [full, coarser] = [
        last + bytes(|name| name == "gather0") + 8.0,
        bytes(|name| name.contains("kernel_conv") && !name.contains('+'))
            + bytes(|name| name.starts_with("pyramid"))
            - 8.0
            + bytes(|name| name.starts_with("gather") && name != "gather0"),
    ];
    assert_eq!(full, 60.0);
    assert!(coarser > 60.0 && coarser < 76.0, "{coarser} bytes per pixel");
    let whole = bytes(|_| true);
    assert!((whole - 454.0 - full - coarser).abs() < 1.0, "{whole} bytes per pixel in all");
}
