//! Further layers of an image, denoised with the weights of its beauty.

use proptest::prelude::*;
use wgdenoise::internals::reference;
use wgdenoise::{Contents, Frame, Image, Inputs, KernelSet, Options, Precision, Quality, Weights};

use crate::support::{
    denoiser_of, frame, images, same_bits, tiny, tiny_demodulation, tiny_kernels,
};
use wgdenoise_testing::gpu::variants;
use wgdenoise_testing::{Random, run_cases};

/// Two layers with their own noise that add up to the image. Subtracting a share is exact enough:
/// the sum differs by at most one unit in the last place.
fn split(image: &Image, seed: u64) -> [Image; 2] {
    let mut random = Random::new(seed);
    let mut layers = [image.clone(), image.clone()];
    for (i, pixel) in image.pixels().iter().enumerate() {
        let part = pixel.map(|v| v * random.value().abs());
        layers[0].pixels_mut()[i] = part;
        layers[1].pixels_mut()[i] = [0, 1, 2].map(|c| pixel[c] - part[c]);
    }
    layers
}

fn denoised(options: &Options, frame: &Frame<'_>, layers: &[&Image]) -> Vec<Image> {
    let frame = frame.layers(layers);
    let found = denoiser_of(&tiny_kernels(), options).denoise_layers(&frame, &mut |_| {});
    let found = found.expect("the frame is fine");
    [found.color].into_iter().chain(found.layers).collect()
}

/// The largest difference of two images, relative to the largest value within 8 pixels.
fn largest_difference(found: impl Fn(usize, usize) -> f32, expected: &Image) -> f32 {
    let (width, height) = expected.size();
    let near = |at: u32, side: u32| at.saturating_sub(8) as usize..(at + 9).min(side) as usize;
    let most_near = |x: u32, y: u32, c: usize| {
        let rows = near(y, height).flat_map(|row| &expected.row(row as u32)[near(x, width)]);
        rows.map(|pixel| pixel[c].abs()).fold(f32::MIN_POSITIVE, f32::max)
    };
    let mut largest = 0.0_f32;
    for (i, pixel) in expected.pixels().iter().enumerate() {
        let [x, y] = [i as u32 % width, i as u32 / width];
        for (c, value) in pixel.iter().enumerate() {
            largest = largest.max((found(i, c) - value).abs() / most_near(x, y, c));
        }
    }
    largest
}

#[test]
fn layers_equal_the_reference() {
    let all = images(41, 23);
    let [first, second] = split(&all[0], 5);
    let (weights, plain) = (tiny_kernels(), frame(&all, Inputs::ALL));
    let scale = reference::autoexposure(&all[0]);
    let images = reference::Images { color: &all[0], albedo: plain.albedo, normal: plain.normal };
    let expected =
        [&first, &second].map(|l| reference::denoise_layer(&weights, images, (l, true), scale));
    run_cases(variants(), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        let found = denoised(&options, &plain.input_scale(scale), &[&first, &second]);
        for (found, expected) in found[1..].iter().zip(&expected) {
            let off = largest_difference(|i, c| found.pixels()[i][c], expected);
            // Logits are rounded; measured 7e-3 and 2e-6. `Half` is off by √19 times as much, as
            // for pixels.
            let most = match (kernels, precision) {
                (KernelSet::Half, _) => 8.7e-2,
                (KernelSet::Matrix(_), _) | (_, Precision::F16) => 2e-2,
                _ => 1e-5,
            };
            if off > most {
                return Err(format!("off by {off}"));
            }
        }
        Ok(())
    });
}

#[test]
fn layers_of_a_picture_sum_to_it() {
    let mut all = images(77, 43);
    // Missing pixels, a firefly and negative light, which the repair changes in all layers alike.
    for (i, value) in [(200, f32::NAN), (500, 1e7), (900, f32::INFINITY)] {
        all[0].pixels_mut()[i] = [value, 1.0, 1.0];
    }
    all[0].pixels_mut()[1200] = [-2.0, 0.1, 0.5];
    let [mut first, second] = split(&all[0], 9);
    first.pixels_mut()[900] = all[0].pixels()[900];
    run_cases(variants(), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        let found = denoised(&options, &frame(&all, Inputs::ALL), &[&first, &second]);
        let sum = |i: usize, c: usize| found[1].pixels()[i][c] + found[2].pixels()[i][c];
        let off = largest_difference(sum, &found[0]);
        if off > 1e-5 { Err(format!("off by {off}")) } else { Ok(()) }
    });
}

#[test]
fn the_beauty_as_a_layer_is_the_beauty_and_a_layer_leaves_the_beauty_alone() {
    let all = images(60, 37);
    let plain = frame(&all, Inputs::ALL);
    run_cases(variants(), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        let alone = &denoised(&options, &plain, &[])[0];
        let found = denoised(&options, &plain, &[&all[2], &all[0]]);
        same_bits(&found[0], alone)?;
        let off = largest_difference(|i, c| found[2].pixels()[i][c], alone);
        if off > 1e-6 { Err(format!("off by {off}")) } else { Ok(()) }
    });
}

#[test]
fn tiled_layers_equal_whole_ones_bit_for_bit() {
    let all = images(300, 210);
    let layers = split(&all[0], 3);
    let layers: Vec<_> = layers.iter().collect();
    run_cases([KernelSet::Plain, KernelSet::Tiled, KernelSet::Simd], |&kernels| {
        let whole = Options::default().kernels(kernels);
        let tiled = whole.clone().tile(Some(144));
        let [whole, tiled] =
            [whole, tiled].map(|options| denoised(&options, &frame(&all, Inputs::ALL), &layers));
        for (tiled, whole) in tiled.iter().zip(&whole) {
            same_bits(tiled, whole)?;
        }
        Ok(())
    });
}

/// The beauty is black except for a square. A layer with noise everywhere keeps it in the black
/// part, and is denoised where the network runs.
#[test]
fn where_the_network_is_skipped_layers_keep_their_pixels_and_bad_ones_are_filled() {
    let [noise, ..] = images(320, 208);
    let mut beauty = Image::filled(320, 208, [0.0; 3]).expect("a valid image");
    for y in 90..110 {
        for x in 30..50 {
            beauty.pixels_mut()[y * 320 + x] = noise.pixels()[y * 320 + x];
        }
    }
    let mut layer = noise.clone();
    layer.pixels_mut()[100 * 320 + 300] = [f32::NAN; 3];
    let found = denoised(&Options::default(), &Frame::new(&beauty), &[&layer]);
    let far = 50 * 320 + 290;
    assert_eq!(found[1].pixels()[far..far + 20], noise.pixels()[far..far + 20]);
    let around = (99..102).flat_map(|y| (299..302).map(move |x| y * 320 + x));
    let around: Vec<_> = around.filter(|&i| i != 100 * 320 + 300).collect();
    for c in 0..3 {
        let mean = around.iter().map(|&i| noise.pixels()[i][c]).sum::<f32>() / 8.0;
        let filled = found[1].pixels()[100 * 320 + 300][c];
        assert!((filled / mean - 1.0).abs() < 1e-5, "{filled}, expected {mean}");
    }
    assert_ne!(found[1].pixels()[100 * 320 + 40], noise.pixels()[100 * 320 + 40]);
}

#[test]
fn a_panoramas_layers_wrap_like_its_color() {
    let all = images(64, 40);
    let [first, second] = split(&all[0], 1);
    let plain = frame(&all, Inputs::ALL).panorama(true);
    let found = denoised(&Options::default().precision(Precision::F32), &plain, &[&first, &second]);
    let sum = |i: usize, c: usize| found[1].pixels()[i][c] + found[2].pixels()[i][c];
    assert_eq!(found[1].size(), (64, 40));
    let off = largest_difference(sum, &found[0]);
    assert!(off < 1e-5, "{off}");
}

#[test]
fn networks_that_predict_color_take_no_layers() {
    let all = images(32, 32);
    let layers = [&all[0]];
    let frame = Frame::new(&all[0]).layers(&layers);
    let denoiser = denoiser_of(&tiny(), &Options::default());
    let error = denoiser.denoise_layers(&frame, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("predict color and not a kernel pyramid"), "{error}");
    denoiser.denoise(&frame).expect("layers are left out");
    let small = Image::filled(31, 32, [0.0; 3]).expect("a valid image");
    let layers = [&small];
    let frame = Frame::new(&all[0]).layers(&layers);
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default());
    let error = denoiser.denoise_layers(&frame, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("a layer is 31×32, but the color is 32×32"), "{error}");
}

#[test]
fn layers_go_one_after_the_other_so_their_number_takes_no_memory_on_the_gpu() {
    let weights = Weights::builtin(Quality::Balanced).expect("it is built in");
    let color = Inputs { albedo: false, normal: false };
    let cases = [
        (KernelSet::Tiled, color, 16),
        (KernelSet::Tiled, Inputs::ALL, 32),
        (KernelSet::Simd, color, 0),
    ];
    for (kernels, inputs, level0) in cases {
        let denoiser = denoiser_of(&weights, &Options::default().kernels(kernels));
        let bytes = |layers| {
            let contents = Contents { inputs, layers };
            denoiser.memory_bytes(256, 256, contents).expect("it fits")
        };
        // The layer and its copy for transfer, plus level 0, with an albedo if the network reads
        // one, where it is not stored anyway.
        assert_eq!(bytes(true) - bytes(false), 256 * 256 * (24 + level0), "{kernels}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn the_result_is_linear_in_the_layer(gain in -20_i32..20, seed in any::<u64>()) {
        let all = images(50, 33);
        let [first, second] = split(&all[0], seed);
        let mut mixed = first.clone();
        let gain = 2_f32.powi(gain);
        for (mixed, other) in mixed.pixels_mut().iter_mut().zip(second.pixels()) {
            *mixed = [0, 1, 2].map(|c| gain * (mixed[c] - 3.0 * other[c]));
        }
        let layers = [&first, &second, &mixed];
        let found = denoised(&Options::default(), &frame(&all, Inputs::ALL), &layers);
        let expected = |i: usize, c: usize| {
            gain * (found[1].pixels()[i][c] - 3.0 * found[2].pixels()[i][c])
        };
        let most = found[0].pixels().iter().flatten().fold(0.0_f32, |most, v| most.max(v.abs()));
        for (i, pixel) in found[3].pixels().iter().enumerate() {
            for (c, value) in pixel.iter().enumerate() {
                let off = (value - expected(i, c)).abs() / gain;
                prop_assert!(off < 1e-5 * most, "{} at {}", off, i);
            }
        }
    }
}

/// The edge of a motion-blurred disc at eight samples: premultiplied color with noisy alpha.
struct Moving {
    noisy: Image,
    alpha: Vec<f32>,
    truth: Image,
    cover: Vec<f32>,
}

impl Moving {
    const SIDE: u32 = 160;
    const COLOR: [f32; 3] = [0.8, 0.5, 0.2];

    fn new() -> Self {
        let cover: Vec<_> = (0..Self::SIDE * Self::SIDE).map(Self::cover).collect();
        let mut random = Random::new(4);
        let mut hit = |cover: f32| u8::from(random.value() * 0.5 + 0.5 < cover);
        let alpha: Vec<_> =
            cover.iter().map(|&c| f32::from((0..8).map(|_| hit(c)).sum::<u8>()) / 8.0).collect();
        let image = |alpha: &[f32]| {
            let pixels = alpha.iter().map(|a| Self::COLOR.map(|v| v * a)).collect();
            Image::new(Self::SIDE, Self::SIDE, pixels).expect("a valid image")
        };
        Self { noisy: image(&alpha), truth: image(&cover), alpha, cover }
    }

    /// The share of the shutter time in which the disc covers a pixel.
    fn cover(i: u32) -> f32 {
        let [x, y] = [i % Self::SIDE, i / Self::SIDE].map(|v| v as f32 - 80.0);
        let covers = (-16..=16).filter(|step| (x + *step as f32).hypot(y) < 40.0);
        covers.count() as f32 / 33.0
    }

    /// Whether the noisy alpha is constant within three pixels.
    fn is_settled(&self, i: usize) -> bool {
        let side = Self::SIDE as usize;
        let near = |at: usize| at.saturating_sub(3)..(at + 4).min(side);
        near(i / side).all(|y| near(i % side).all(|x| self.alpha[y * side + x] == self.alpha[i]))
    }

    /// The mean difference from the truth over a background, along the blurred edge.
    fn error(&self, image: &Image, alpha: &[f32], background: f32) -> f32 {
        let over = |pixel: [f32; 3], alpha: f32| pixel.map(|v| v + (1.0 - alpha) * background);
        let edge = (0..self.cover.len()).filter(|&i| (0.05..0.95).contains(&self.cover[i]));
        let off = edge.map(|i| {
            let expected = over(self.truth.pixels()[i], self.cover[i]);
            let found = over(image.pixels()[i], alpha[i]);
            [0, 1, 2].map(|c| (found[c] - expected[c]).abs()).iter().sum::<f32>()
        });
        let errors: Vec<_> = off.collect();
        errors.iter().sum::<f32>() / errors.len() as f32
    }
}

#[test]
fn premultiplied_edges_get_better_over_any_background() {
    let moving = Moving::new();
    for quality in Quality::ALL {
        let weights = Weights::builtin(quality).expect("it is built in");
        let denoiser = denoiser_of(&weights, &Options::default());
        let frame = Frame::new(&moving.noisy).alpha(moving.alpha.as_slice());
        let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
        let alpha = found.alpha.expect("it was given");
        for background in [0.0, 0.5, 1.0] {
            let before = moving.error(&moving.noisy, &moving.alpha, background);
            let after = moving.error(&found.color, &alpha, background);
            assert!(after < 0.7 * before, "{quality:?} over {background}: {before} to {after}");
        }
        for (i, pixel) in found.color.pixels().iter().enumerate() {
            // Color and alpha are the same weighted mean, so there is no light where alpha is 0.
            let expected = Moving::COLOR.map(|v| v * alpha[i]);
            let is_off = (0..3).any(|c| (pixel[c] - expected[c]).abs() > 1e-5);
            assert!(!is_off, "{quality:?}: {pixel:?} at {i}, alpha {}", alpha[i]);
        }
        let settled = (0..alpha.len()).filter(|&i| moving.is_settled(i));
        let (ones, zeros): (Vec<_>, Vec<_>) = settled.partition(|&i| moving.alpha[i] == 1.0);
        assert!(ones.len() > 100 && zeros.len() > 100, "{} {}", ones.len(), zeros.len());
        assert!(ones.iter().all(|&i| alpha[i] == 1.0), "{quality:?}: alpha of 1");
        let is_empty = |i: &usize| alpha[*i] == 0.0 && found.color.pixels()[*i] == [0.0; 3];
        assert!(zeros.iter().all(is_empty), "{quality:?}: alpha of 0");
    }
}

#[test]
fn alpha_must_have_a_value_per_pixel() {
    let all = images(32, 32);
    let frame = Frame::new(&all[0]).alpha([0.5; 31].as_slice());
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default());
    let error = denoiser.denoise_layers(&frame, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("alpha has 31 values, but the color has 1024 pixels"), "{error}");
}

/// Where nothing has any weight, no layer has a color, however bright its own pixels are.
#[test]
fn without_any_color_every_layer_is_black() {
    let mut all = images(40, 24);
    let layer = Image::filled(40, 24, [2.0, 0.5, 100.0]).expect("a valid image");
    all[0] = Image::filled(40, 24, [f32::NAN; 3]).expect("a valid image");
    let layers = [&layer];
    run_cases(variants(), |&(kernels, precision)| {
        let options = Options::default().kernels(kernels).precision(precision);
        for weights in [tiny_kernels(), tiny_demodulation()] {
            let frame = frame(&all, Inputs::ALL).layers(&layers);
            let denoiser = denoiser_of(&weights, &options);
            let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
            same_bits(&found.layers[0], &Image::filled(40, 24, [0.0; 3]).expect("a valid image"))?;
        }
        Ok(())
    });
}
