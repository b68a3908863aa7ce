//! Guarantees of a demodulating kernel pyramid with any weights.

use std::collections::HashMap;

use proptest::prelude::*;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView, serialize};
use wgdenoise::internals::plan::halo::constant_radius;
use wgdenoise::internals::reference;
use wgdenoise::{Frame, Image, Inputs, KernelSet, Options, Precision, Weights};

use crate::support::{denoiser_of, frame, images, same_bits, tiny_demodulation};
use wgdenoise_testing::fixture::Fixture;
use wgdenoise_testing::gpu::{kernel_sets, variants};
use wgdenoise_testing::run_cases;

/// Shape and bytes of a tensor.
type Stored = (Dtype, Vec<usize>, Vec<u8>);

/// The tiny network after changing its first logits' weight and bias, with one row per logit.
fn with_logits(change: impl Fn(&mut Stored)) -> Weights {
    let bytes = Fixture::open("demodulating_tiny").bytes;
    let (_, header) = SafeTensors::read_metadata(&bytes).expect("the fixture is safetensors");
    let file = SafeTensors::deserialize(&bytes).expect("the fixture is safetensors");
    let stored = |(name, view): (String, TensorView<'_>)| {
        let mut tensor = (view.dtype(), view.shape().to_vec(), view.data().to_vec());
        if name.starts_with("kernel_conv0.") {
            change(&mut tensor);
        }
        (name, tensor)
    };
    let tensors: HashMap<_, _> = file.tensors().into_iter().map(stored).collect();
    let views = tensors.iter().map(|(name, (dtype, shape, data))| {
        (name, TensorView::new(*dtype, shape.clone(), data).expect("the size is right"))
    });
    let metadata = header.metadata().clone();
    Weights::from_bytes(&serialize(views, metadata).expect("it can be written"))
        .expect("it is valid")
}

/// The tiny network without the power's logit.
fn undemodulated() -> Weights {
    with_logits(|(_, shape, bytes)| {
        bytes.truncate(bytes.len() / shape[0] * 11);
        shape[0] = 11;
    })
}

/// The tiny network with a power of 0 or 1 everywhere.
fn with_power(power: u8) -> Weights {
    let logit = f32::from(power) * 16.0 - 8.0;
    with_logits(|(dtype, shape, bytes)| {
        let begin = bytes.len() / shape[0] * 11;
        bytes[begin..].fill(0);
        match (shape.len(), dtype) {
            (1, Dtype::F32) => bytes[begin..].copy_from_slice(&logit.to_le_bytes()),
            (1, _) => bytes[begin..].copy_from_slice(&half::f16::from_f32(logit).to_le_bytes()),
            _ => {}
        }
    })
}

fn run(weights: &Weights, options: &Options, frame: &Frame<'_>) -> Image {
    denoiser_of(weights, options).denoise(frame).expect("the frame is fine")
}

fn options(kernels: KernelSet, precision: Precision) -> Options {
    Options::default().kernels(kernels).precision(precision)
}

fn mapped(image: &Image, map: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Image {
    let pixels = image.pixels().iter().enumerate().map(|(i, pixel)| map(i, *pixel)).collect();
    Image::new(image.width(), image.height(), pixels).expect("the size is the same")
}

#[test]
fn without_albedo_or_with_a_constant_one_not_a_bit_differs_from_a_network_without_demodulation() {
    let mut all = images(41, 23);
    all[1] = Image::filled(41, 23, [0.7, 0.1, 0.0]).expect("a valid image");
    let networks = [tiny_demodulation(), undemodulated()];
    let sets = [Inputs { albedo: false, normal: true }, Inputs::ALL];
    let cases = variants().into_iter().flat_map(|variant| sets.map(|inputs| (variant, inputs)));
    run_cases(cases, |&((kernels, precision), inputs)| {
        let [found, expected] = networks
            .each_ref()
            .map(|weights| run(weights, &options(kernels, precision), &frame(&all, inputs)));
        same_bits(&found, &expected)
    });
    // Texture must make a difference.
    let textured = images(41, 23);
    let [found, plain] = networks
        .each_ref()
        .map(|weights| run(weights, &Options::default(), &frame(&textured, Inputs::ALL)));
    same_bits(&found, &plain).unwrap_err();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn a_gain_of_a_power_of_two_changes_no_bit_but_the_exponent(power in -40_i32..40) {
        let dim = images(37, 22);
        let gain = 2_f32.powi(power);
        let mut bright = dim.clone();
        bright[0] = mapped(&dim[0], |_, pixel| pixel.map(|v| v * gain));
        let (weights, options) = (tiny_demodulation(), Options::default());
        let run = |images, scale| {
            run(&weights, &options, &frame(images, Inputs::ALL).input_scale(scale))
        };
        let expected = mapped(&run(&dim, 0.5), |_, pixel| pixel.map(|v| v * gain));
        same_bits(&run(&bright, 0.5 / gain), &expected).map_err(TestCaseError::fail)?;
    }
}

/// Albedo from 0.45 to 1, which limits the brightness ratio of two pixels to 1.05/0.5 = 2.1.
fn mild(albedo: &Image) -> Image {
    mapped(albedo, |_, pixel| pixel.map(|v| 0.45 + 0.55 * v))
}

/// Sums round by 10⁻⁵ of the brightest light nearby, which the texture multiplies by up to 2.1.
#[test]
fn light_groups_add_up_to_the_color() {
    let mut all = images(77, 43);
    all[1] = mild(&all[1]);
    all[0].pixels_mut()[200] = [f32::NAN, 1.0, 1.0];
    all[0].pixels_mut()[500] = [1e7, 1.0, 1.0];
    let part = |i: usize| (i * 37 % 101) as f32 / 101.0;
    let groups = [
        mapped(&all[0], |i, pixel| pixel.map(|v| v * part(i))),
        mapped(&all[0], |i, pixel| pixel.map(|v| v - v * part(i))),
    ];
    let layers = groups.each_ref();
    run_cases(variants(), |&(kernels, precision)| {
        let denoiser = denoiser_of(&tiny_demodulation(), &options(kernels, precision));
        let frame = frame(&all, Inputs::ALL).layers(&layers);
        let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
        let sum = mapped(&found.layers[0], |i, pixel| {
            [0, 1, 2].map(|c| pixel[c] + found.layers[1].pixels()[i][c])
        });
        let off = farthest(&sum, &found.color);
        if off < 2.1 * 1e-5 { Ok(()) } else { Err(format!("off by {off}")) }
    });
}

/// The largest difference, relative to the brightest channel within 8 pixels.
fn farthest(found: &Image, expected: &Image) -> f32 {
    let (width, height) = expected.size();
    let near = |at: u32, side: u32| at.saturating_sub(8)..(at + 9).min(side);
    let brightest = |x: u32, y: u32, c: usize| {
        let rows = near(y, height).map(|row| expected.row(row));
        let values = rows.flat_map(|row| near(x, width).map(|x| row[x as usize][c].abs()));
        values.fold(f32::MIN_POSITIVE, f32::max)
    };
    let off = |i: u32, c: usize| {
        let difference = found.pixels()[i as usize][c] - expected.pixels()[i as usize][c];
        difference.abs() / brightest(i % width, i / width, c)
    };
    let all = (0..width * height).flat_map(|i| [0, 1, 2].map(|c| off(i, c)));
    all.fold(0.0, |most, off| if off <= most { most } else { off })
}

#[test]
fn alpha_is_averaged_as_without_demodulation() {
    let all = images(60, 37);
    let noisy: Vec<_> = (0..60 * 37).map(|i| (i * 29 % 11) as f32 / 10.0).collect();
    run_cases(variants(), |&(kernels, precision)| {
        let options = options(kernels, precision);
        let denoise = |weights: &Weights, alpha: &[f32], panorama| {
            let frame = frame(&all, Inputs::ALL).alpha(alpha).panorama(panorama);
            let denoiser = denoiser_of(weights, &options);
            denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine")
        };
        // With a power of 1, alpha would not stay 1 if it were demodulated.
        let opaque = denoise(&with_power(1), &[1.0; 60 * 37], false);
        let alone = run(&with_power(1), &options, &frame(&all, Inputs::ALL));
        same_bits(&opaque.color, &alone)?;
        let is_same = |panorama| {
            let [found, expected] = [tiny_demodulation(), undemodulated()]
                .map(|weights| denoise(&weights, &noisy, panorama).alpha);
            found == expected
        };
        if opaque.alpha == Some(vec![1.0; 60 * 37]) && is_same(false) && is_same(true) {
            return Ok(());
        }
        Err("alpha has a texture".into())
    });
}

/// Light of a lamp that shines evenly on a texture is proportional to albedo + 0.05. A power of 1
/// must reproduce it, whatever is gathered.
#[test]
fn light_that_follows_the_texture_comes_back() {
    let [_, albedo, normal] = images(61, 45);
    let input = reference::input_process(&albedo, Some(&albedo), None, 1.0, 16);
    let seen = |i: usize, c: usize| input.at(3 + c, i / 61, i % 61);
    let lamp = [0.8, 0.5, 0.2];
    let light = mapped(&albedo, |i, _| [0, 1, 2].map(|c| lamp[c] * (seen(i, c) + 0.05)));
    let frame = Frame::new(&light).albedo(&albedo).normal(&normal);
    let most = |weights: &Weights, kernels, precision| {
        let found = run(weights, &options(kernels, precision), &frame);
        let pairs = found.pixels().iter().flatten().zip(light.pixels().iter().flatten());
        pairs.map(|(found, expected)| (found / expected - 1.0).abs()).fold(0.0_f32, f32::max)
    };
    run_cases(variants(), |&(kernels, precision)| {
        let (off, blurred) =
            (most(&with_power(1), kernels, precision), most(&with_power(0), kernels, precision));
        // Light and albedo are gathered with the same weights and differ only in rounding, by 10⁻⁵
        // of the light nearby.
        if off < 1e-4 && blurred > 0.5 {
            return Ok(());
        }
        Err(format!("off by {off}, and by {blurred} without demodulation"))
    });
}

#[test]
fn huge_and_tiny_light_on_black_and_white_stays_finite() {
    let mut all = images(64, 48);
    let exponent = |i: usize| [1e-12, 1e-3, 65504.0][i * 7 % 3];
    all[0] = mapped(&all[0], |i, _| [exponent(i), exponent(i / 2), exponent(i / 64)]);
    all[1] = mapped(&all[1], |i, _| [((i + i / 64) % 2) as f32; 3]);
    run_cases(variants(), |&(kernels, precision)| {
        for weights in [tiny_demodulation(), with_power(1)] {
            let found = run(&weights, &options(kernels, precision), &frame(&all, Inputs::ALL));
            let is_fine = |v: &f32| v.is_finite() && *v >= 0.0;
            if !found.pixels().as_flattened().iter().all(is_fine) {
                return Err("not all is light".into());
            }
        }
        Ok(())
    });
}

/// Where the network is skipped, constant light on a texture and the layers keep their bits, except
/// for a bad pixel, which is filled; the rest is the same as without skipping.
#[test]
fn clean_blocks_keep_their_light_and_the_others_are_as_without_skipping() {
    let [noise, albedo, normal] = images(160, 144);
    let is_noisy = |i: usize| i % 160 < 40 && i / 160 < 30;
    let color = mapped(&noise, |i, pixel| if is_noisy(i) { pixel } else { [0.25, 0.5, 2.0] });
    // The noisy blocks cover 48 × 32 pixels.
    let radius = 16 * constant_radius(tiny_demodulation().network()) as usize;
    let is_clean = |i: usize| i % 160 >= 48 + radius || i / 160 >= 32 + radius;
    let bad = 100 * 160 + 120;
    let mut layer = noise.clone();
    layer.pixels_mut()[bad] = [f32::NAN; 3];
    let layers = [&layer];
    let frame = Frame::new(&color).albedo(&albedo).normal(&normal).layers(&layers);
    for kernels in kernel_sets(Precision::F16) {
        if kernels == KernelSet::Plain {
            continue;
        }
        let [mut skipping, full] = [true, false].map(|skip| {
            let options = Options::default().kernels(kernels).skip_clean(skip);
            let denoiser = denoiser_of(&tiny_demodulation(), &options);
            denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine")
        });
        let filled =
            std::mem::replace(&mut skipping.layers[0].pixels_mut()[bad], noise.pixels()[bad]);
        let rows = [bad - 160, bad, bad + 160];
        let around = rows.iter().flat_map(|i| [i - 1, *i, i + 1]).filter(|i| *i != bad);
        let around: Vec<_> = around.map(|i| noise.pixels()[i]).collect();
        for c in 0..3 {
            let mean = around.iter().map(|pixel| pixel[c]).sum::<f32>() / 8.0;
            // Eight sums and products, and two exponentials of up to ±3.05.
            assert!((filled[c] / mean - 1.0).abs() < 40.0 * f32::EPSILON, "{kernels}: {filled:?}");
        }
        let pairs = [
            (&skipping.color, &color, &full.color),
            (&skipping.layers[0], &noise, &full.layers[0]),
        ];
        for (found, own, full) in pairs {
            let expected = mapped(own, |i, own| if is_clean(i) { own } else { full.pixels()[i] });
            same_bits(found, &expected).unwrap();
        }
    }
}

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let all = images(210, 190);
    let layers = [&all[2]];
    let frame = frame(&all, Inputs::ALL).layers(&layers);
    run_cases(variants(), |&(kernels, precision)| {
        let [whole, tiled] = [None, Some(144)].map(|tile| {
            let options = options(kernels, precision).tile(tile);
            let denoiser = denoiser_of(&tiny_demodulation(), &options);
            let plan = denoiser.tile_plan(210, 190, frame.contents()).expect("it fits");
            let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
            (found, plan.tiles.len())
        });
        if whole.1 != 1 || tiled.1 < 9 {
            return Err(format!("{} tiles test nothing", tiled.1));
        }
        same_bits(&tiled.0.color, &whole.0.color)?;
        same_bits(&tiled.0.layers[0], &whole.0.layers[0])
    });
}

#[test]
fn demodulation_takes_memory_only_where_it_is_used() {
    run_cases(variants(), |&(kernels, precision)| {
        let [demodulating, plain] = [tiny_demodulation(), undemodulated()]
            .map(|weights| denoiser_of(&weights, &options(kernels, precision)));
        let more = |inputs: Inputs| {
            let bytes = [&demodulating, &plain].map(|d| d.memory_bytes(256, 256, inputs).unwrap());
            bytes[0] - bytes[1]
        };
        // An albedo of 16 bytes in the pyramid and in its results. GPUs do not store level 0.
        let level0 = if kernels.is_for_gpus() { 0 } else { 256 * 256 };
        let albedo = 16 * (level0 + 2 * (128 * 128 + 64 * 64 + 32 * 32));
        let found = [more(Inputs::ALL), more(Inputs { albedo: false, normal: true })];
        if found == [albedo, 0] { Ok(()) } else { Err(format!("{found:?} bytes")) }
    });
}

#[test]
fn the_albedo_takes_no_calls_of_its_own() {
    let all = images(48, 32);
    let denoiser = denoiser_of(&tiny_demodulation(), &Options::default());
    let calls = |inputs| {
        let rows = denoiser.profile(&frame(&all, inputs), 1).expect("the frame is fine");
        rows.into_iter().map(|row| row.name).collect::<Vec<_>>()
    };
    assert_eq!(calls(Inputs::ALL), calls(Inputs { albedo: false, normal: true }));
}

#[test]
fn the_reference_verifies_the_color_with_and_without_alpha() {
    let all = images(80, 60);
    // The color depends on alpha only where alpha is settled, as on the right.
    let noisy = |i: usize| (i * 29 % 11) as f32 / 10.0;
    let alpha: Vec<_> = (0..80 * 60).map(|i| if i % 80 < 20 { noisy(i) } else { 1.0 }).collect();
    for options in [Options::default(), Options::default().precision(Precision::F32)] {
        let denoiser = denoiser_of(&tiny_demodulation(), &options);
        for frame in [frame(&all, Inputs::ALL), frame(&all, Inputs::ALL).alpha(alpha.as_slice())] {
            let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
            let verified = denoiser.verify(&frame, &found.color).expect("it is right");
            assert!(verified.is_some());
        }
    }
}
