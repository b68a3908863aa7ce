//! Constant surroundings skip the network and change nothing else.

use wgdenoise::internals::plan::halo::constant_radius;
use wgdenoise::{Image, Inputs, Options, Precision};

use crate::support::{denoiser, frame, images, run, same_bits, tiny};
use wgdenoise_testing::gpu::{fused_sets, variants_of};
use wgdenoise_testing::{Random, run_cases};

const SIZE: [u32; 2] = [420, 260];

/// A noisy disc on a constant background.
fn disc() -> [Image; 3] {
    let [noise, albedo, normal] = images(SIZE[0], SIZE[1]);
    let mut color = noise;
    for (i, pixel) in (0..).zip(color.pixels_mut()) {
        if !is_in_disc([i % SIZE[0], i / SIZE[0]]) {
            *pixel = [0.25, 0.5, -0.125];
        }
    }
    [color, albedo, normal]
}

fn is_in_disc([x, y]: [u32; 2]) -> bool {
    (f64::from(x) - 90.0).hypot(f64::from(y) - 100.0) <= 60.0
}

/// For each pixel, whether its 16×16 block or one that its color may depend on has pixels of the
/// disc.
fn is_near_disc(i: usize) -> bool {
    let radius = constant_radius(tiny().network()) * 16;
    let block = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|p| p / 16 * 16);
    let [columns, rows] = block.map(|first| first.saturating_sub(radius)..first + 16 + radius);
    rows.flat_map(|y| columns.clone().map(move |x| [x, y])).any(is_in_disc)
}

#[test]
fn clean_blocks_keep_their_bits_and_the_others_get_the_same_as_without_skipping() {
    let images = disc();
    let near: Vec<bool> = (0..images[0].pixels().len()).map(is_near_disc).collect();
    for inputs in [Inputs::ALL, Inputs::default()] {
        let frame = frame(&images, inputs);
        run_cases(fused_sets(Precision::F16), |&kernels| {
            let options = Options::default().kernels(kernels);
            let skipping = run(&options, &frame);
            let full = run(&options.skip_clean(false), &frame);
            let (mut kept, mut changed) = (0, 0);
            for (i, found) in skipping.pixels().iter().enumerate() {
                let expected = if near[i] { full.pixels()[i] } else { images[0].pixels()[i] };
                if found.map(f32::to_bits) != expected.map(f32::to_bits) {
                    return Err(format!("pixel {i}: {found:?}, expected {expected:?}"));
                }
                kept += usize::from(!near[i]);
                changed += usize::from(full.pixels()[i] != images[0].pixels()[i]);
            }
            // Both kinds must occur, and the network must change pixels.
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

/// The result is bit-identical for channels of any sign, unless the light as a whole is negative.
#[test]
fn an_image_of_one_color_comes_back_as_it_was() {
    let [_, albedo, normal] = images(70, 51);
    for (color, expected) in [
        ([0.5, 1.0, 1.1], [0.5, 1.0, 1.1]),
        ([-0.25, 0.5, -0.0], [-0.25, 0.5, -0.0]),
        ([-1.0, 0.1, -2.0], [0.0, 0.1, 0.0]),
        ([1e-42; 3], [1e-42; 3]),
    ] {
        let [color, expected] = [color, expected].map(|c| Image::filled(70, 51, c).unwrap());
        let images = [color, albedo.clone(), normal.clone()];
        let found = run(&Options::default(), &frame(&images, Inputs::ALL));
        same_bits(&found, &expected).unwrap();
    }
}

#[test]
fn what_is_only_nearly_constant_is_denoised_everywhere() {
    let gray = |v: f32| [0.5, v, v];
    let mut random = Random::new(5);
    let mut noise = |contrast: f32| {
        (0..96 * 64).map(|_| gray(1.0 + contrast * random.value())).collect::<Vec<_>>()
    };
    let ramp = (0..96 * 64).map(|i| gray(1.0 + (i % 96) as f32 * 1e-5)).collect();
    for pixels in [noise(0.05), noise(1e-4), ramp] {
        let mut images = images(96, 64);
        images[0] = Image::new(96, 64, pixels).unwrap();
        let frame = frame(&images, Inputs::ALL);
        let full = run(&Options::default().skip_clean(false), &frame);
        same_bits(&run(&Options::default(), &frame), &full).unwrap();
    }
}
