//! Networks shaped like Open Image Denoise's, which also use the input as a skip.

use wgdenoise::internals::model::tza;
use wgdenoise::internals::reference;
use wgdenoise::{Denoiser, Frame, Image, Inputs, Options, Weights};

use crate::overflow::times;
use crate::support::{encoded, expected, frame, images, same_bits, tolerance};
use wgdenoise_testing::gpu::{gpu, variants};
use wgdenoise_testing::{Tolerance, compare, image_tensor, run_cases};

/// Small networks with random weights, made by `training/make_oidn_fixtures.py`.
fn networks() -> [Weights; 2] {
    let base = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm.tza");
    let large = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm_large.tza");
    [(&base[..], "rt_hdr_alb_nrm"), (large, "rt_hdr_alb_nrm_large")]
        .map(|(bytes, name)| Weights::from_tza(bytes, name).expect("the fixture is whole"))
}

/// A network for color only; its name determines the color's encoding.
pub(crate) fn color_network(name: &str) -> Weights {
    let bytes = include_bytes!("../fixtures/oidn/rt_alb.tza");
    Weights::from_tza(bytes, name).expect("the fixture is whole")
}

fn run(weights: &Weights, options: &Options, images: &[Image; 3]) -> Image {
    let denoiser = Denoiser::new(&gpu().device, &gpu().queue, weights, options);
    let frame = frame(images, Inputs::ALL);
    let denoised = denoiser.expect("the device works").denoise(&frame);
    denoised.expect("the frame is fine")
}

#[test]
fn every_variant_equals_the_reference() {
    let (networks, images) = (networks(), images(37, 22));
    let frame = frame(&images, Inputs::ALL);
    let scale = reference::autoexposure(frame.color);
    for weights in &networks {
        let expected = encoded(&expected(weights, &frame), scale);
        run_cases(variants(), |&(kernels, precision)| {
            let found =
                run(weights, &Options::default().kernels(kernels).precision(precision), &images);
            compare(&encoded(&found, scale), &expected, tolerance(kernels, precision))
        });
    }
}

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let images = images(250, 130);
    for weights in &networks() {
        run_cases(variants(), |&(kernels, precision)| {
            let options = Options::default().kernels(kernels).precision(precision);
            let tiled = options.clone().tile(240);
            same_bits(&run(weights, &tiled, &images), &run(weights, &options, &images))
        });
    }
}

#[test]
fn results_in_every_encoding_are_verified_and_wrong_ones_refused() {
    let images = images(70, 50);
    let noise = images[2].clone();
    for name in ["rt_hdr", "rtlightmap_hdr", "rt_ldr", "rt_nrm"] {
        let bytes = tza::to_safetensors(include_bytes!("../fixtures/oidn/rt_alb.tza"), name);
        let is_hdr = name.ends_with("hdr");
        // The factor brings light that encodes beyond 1, as the input does.
        let factor = if is_hdr { 1.3 } else { 1.0 };
        let weights = times(&bytes.expect("the fixture is whole"), factor);
        run_cases(variants(), |&(kernels, precision)| {
            let color = if name == "rt_nrm" { &noise } else { &images[1] };
            let input_scale = is_hdr.then_some(1e9);
            let frame = Frame::new(color).input_scale(input_scale);
            let options = Options::default().kernels(kernels).precision(precision);
            let denoiser = Denoiser::new(&gpu().device, &gpu().queue, &weights, &options);
            let denoiser = denoiser.expect("the device works");
            let mut result = denoiser.denoise(&frame).map_err(|e| e.to_string())?;
            let verified = denoiser.verify(&frame, &result).map_err(|e| e.to_string())?;
            let verified = verified.ok_or("there is noise")?;
            println!("{name}, {kernels}, {precision:?}: {verified}");
            let rows = verified.rect.begin[1]..verified.rect.end[1];
            let columns = verified.rect.begin[0] as usize..verified.rect.end[0] as usize;
            let compared = rows.flat_map(|y| result.row(y)[columns.clone()].iter().flatten());
            let brightest = compared.fold(0.0_f32, |a, &b| a.max(b));
            if is_hdr && brightest * 1e9 < 65504.0 {
                return Err(format!("{name}: nothing is encoded beyond 1"));
            }
            result.pixels_mut().iter_mut().flatten().for_each(|v| *v = *v * 0.9 - 0.05);
            let refused = denoiser.verify(&frame, &result).is_err();
            refused.then_some(()).ok_or_else(|| format!("{name}: a wrong result is accepted"))
        });
    }
}

#[test]
fn display_color_is_neither_exposed_nor_encoded_as_light() {
    let [mut color, albedo, normal] = images(37, 22);
    color.pixels_mut().iter_mut().flatten().for_each(|v| *v = (*v * 0.1).min(1.0));
    let images = [color, albedo, normal];
    let bytes = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm.tza");
    let weights = Weights::from_tza(bytes, "rt_ldr_alb_nrm").expect("the fixture is whole");
    let expected = image_tensor(&expected(&weights, &frame(&images, Inputs::ALL)));
    run_cases(variants(), |&(kernels, precision)| {
        let found =
            run(&weights, &Options::default().kernels(kernels).precision(precision), &images);
        // The curve back to linear light has a slope of at most 2.3.
        let encoded = tolerance(kernels, precision);
        let allowed = Tolerance { absolute: 2.3 * encoded.absolute, ..encoded };
        compare(&image_tensor(&found), &expected, allowed)
    });
}
