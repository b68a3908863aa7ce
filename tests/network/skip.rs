//! Noise-free blocks skip the network and change nothing else.

use wgdenoise::{Image, Inputs, Options, Precision};

use crate::support::{denoiser, frame, images, run, same_bits};
use wgdenoise_testing::gpu::{fused_sets, variants_of};
use wgdenoise_testing::{Random, run_cases};

const SIZE: [u32; 2] = [420, 260];

/// Noise in a disc, on a noise-free background.
fn disc() -> [Image; 3] {
    let [noise, albedo, normal] = images(SIZE[0], SIZE[1]);
    let mut color = noise;
    for (i, pixel) in (0..).zip(color.pixels_mut()) {
        let [x, y] = [i % SIZE[0], i / SIZE[0]].map(f64::from);
        if (x - 90.0).hypot(y - 100.0) > 60.0 {
            *pixel = [0.25, 0.5, 2.0 + x as f32 * 1e-5];
        }
    }
    [color, albedo, normal]
}

/// For each block of 16×16 pixels, whether it contains pixels of the disc.
fn is_noisy(i: usize) -> bool {
    let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|p| p / 16 * 16);
    let inside = |[x, y]: [u32; 2]| (f64::from(x) - 90.0).hypot(f64::from(y) - 100.0) <= 60.0;
    (0..256).any(|i| inside([x + i % 16, y + i / 16]))
}

#[test]
fn clean_blocks_keep_their_bits_and_the_others_get_the_same_as_without_skipping() {
    let images = disc();
    for inputs in [Inputs::ALL, Inputs::default()] {
        let frame = frame(&images, inputs);
        run_cases(fused_sets(Precision::F16), |&kernels| {
            let options = Options::default().kernels(kernels);
            let skipping = run(&options, &frame);
            let full = run(&options.skip_clean(false), &frame);
            let (mut kept, mut changed) = (0, 0);
            for (i, found) in skipping.pixels().iter().enumerate() {
                let expected = if is_noisy(i) { full.pixels()[i] } else { images[0].pixels()[i] };
                if found.map(f32::to_bits) != expected.map(f32::to_bits) {
                    return Err(format!("pixel {i}: {found:?}, expected {expected:?}"));
                }
                kept += usize::from(!is_noisy(i));
                changed += usize::from(full.pixels()[i] != images[0].pixels()[i]);
            }
            // Both kinds must occur, and the network must not be the identity.
            let all = images[0].pixels().len();
            (kept > all / 2 && kept < all && changed > all / 2)
                .then_some(())
                .ok_or_else(|| format!("{kept} kept, {changed} changed of {all}"))
        });
    }
}

#[test]
fn tiles_skip_the_same_blocks_as_the_whole_image() {
    let images = disc();
    let frame = frame(&images, Inputs::ALL);
    run_cases(variants_of(fused_sets), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        let tiled = options.clone().tile(112);
        let plan = denoiser(&tiled).tile_plan(SIZE[0], SIZE[1], Inputs::ALL).unwrap();
        assert!(plan.tiles.len() > 8, "{} tiles", plan.tiles.len());
        same_bits(&run(&tiled, &frame), &run(&options, &frame))
    });
}

#[test]
fn an_image_without_noise_comes_back_as_it_was() {
    let gradient = |i: u32| [0.5, 1.0 + (i % 70) as f32 * 1e-3, 1.0 + (i / 70) as f32 * 1e-3];
    let color = Image::new(70, 51, (0..70 * 51).map(gradient).collect()).unwrap();
    let [_, albedo, normal] = images(70, 51);
    let images = [color, albedo, normal];
    let found = run(&Options::default(), &frame(&images, Inputs::ALL));
    same_bits(&found, &images[0]).unwrap();
}

#[test]
fn a_noisy_image_is_denoised_everywhere() {
    let mut random = Random::new(5);
    let mut images = images(96, 64);
    for pixel in images[0].pixels_mut() {
        *pixel = [1.0 + 0.05 * random.value(); 3];
    }
    let frame = frame(&images, Inputs::ALL);
    let full = run(&Options::default().skip_clean(false), &frame);
    same_bits(&run(&Options::default(), &frame), &full).unwrap();
}
