//! Networks of the shape of Open Image Denoise's: the input is a skip, too.

use wgdenoise::{Denoiser, Frame, Image, Inputs, Options, Weights, reference};

use crate::common::gpu::{gpu, variants};
use crate::common::{Tolerance, compare, image_tensor, run_cases};
use crate::support::{encoded, expected, frame, images, same_bits, tolerance};

/// Small ones with random weights, by `training/make_oidn_fixtures.py`.
fn networks() -> [Weights; 2] {
    let base = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm.tza");
    let large = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm_large.tza");
    [(&base[..], "rt_hdr_alb_nrm"), (large, "rt_hdr_alb_nrm_large")]
        .map(|(bytes, name)| Weights::from_tza(bytes, name).expect("the fixture is whole"))
}

/// One for colour alone, under the name that says what the colour is.
pub(crate) fn color_network(name: &str) -> Weights {
    let bytes = include_bytes!("../fixtures/oidn/rt_alb.tza");
    Weights::from_tza(bytes, name).expect("the fixture is whole")
}

fn run(weights: &Weights, options: &Options, images: &[Image; 3]) -> Image {
    let denoiser = Denoiser::new(&gpu().device, &gpu().queue, weights, options);
    let frame = frame(images, Inputs::ALL);
    let denoised = denoiser.expect("the device works").denoise(&frame, &mut |_, _| {});
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
                run(weights, &Options { kernels, precision, ..Options::default() }, &images);
            compare(&encoded(&found, scale), &expected, tolerance(kernels, precision))
        });
    }
}

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let images = images(250, 130);
    for weights in &networks() {
        run_cases(variants(), |&(kernels, precision)| {
            let options = Options { kernels, precision, ..Options::default() };
            let tiled = Options { tile: Some(240), ..options.clone() };
            same_bits(&run(weights, &tiled, &images), &run(weights, &options, &images))
        });
    }
}

#[test]
fn results_in_every_encoding_are_verified_and_wrong_ones_refused() {
    let images = images(70, 50);
    let noise = images[2].clone();
    // Light in the noisiest block that is brighter, exposed, than what is encoded as 1.
    let mut lamp = images[1].clone();
    for row in lamp.pixels_mut().chunks_mut(70).take(16) {
        row[..16].iter_mut().step_by(2).for_each(|p| *p = p.map(|v| v * 1e8));
    }
    for name in ["rt_hdr", "rtlightmap_hdr", "rt_ldr", "rt_nrm"] {
        let weights = color_network(name);
        run_cases(variants(), |&(kernels, precision)| {
            let color = match name {
                "rt_nrm" => &noise,
                "rt_hdr" | "rtlightmap_hdr" => &lamp,
                _ => &images[1],
            };
            let frame = Frame { color, albedo: None, normal: None, input_scale: None };
            let options = Options { kernels, precision, ..Options::default() };
            let denoiser = Denoiser::new(&gpu().device, &gpu().queue, &weights, &options);
            let denoiser = denoiser.expect("the device works");
            let mut result = denoiser.denoise(&frame, &mut |_, _| {}).map_err(|e| e.to_string())?;
            let verified = denoiser.verify(&frame, &result).map_err(|e| e.to_string())?;
            let verified = verified.ok_or("there is noise")?;
            println!("{name}, {kernels}, {precision:?}: {verified}");
            result.pixels_mut().iter_mut().flatten().for_each(|v| *v = *v * 0.9 - 0.05);
            let refused = denoiser.verify(&frame, &result).is_err();
            refused.then_some(()).ok_or_else(|| format!("{name}: a wrong result is accepted"))
        });
    }
}

#[test]
fn display_colour_is_neither_exposed_nor_encoded_as_light() {
    let [mut color, albedo, normal] = images(37, 22);
    color.pixels_mut().iter_mut().flatten().for_each(|v| *v = (*v * 0.1).min(1.0));
    let images = [color, albedo, normal];
    let bytes = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm.tza");
    let weights = Weights::from_tza(bytes, "rt_ldr_alb_nrm").expect("the fixture is whole");
    let expected = image_tensor(&expected(&weights, &frame(&images, Inputs::ALL)));
    run_cases(variants(), |&(kernels, precision)| {
        let found = run(&weights, &Options { kernels, precision, ..Options::default() }, &images);
        // The curve back to linear light is 2.3 times as steep as a line at most.
        let encoded = tolerance(kernels, precision);
        let allowed = Tolerance { absolute: 2.3 * encoded.absolute, ..encoded };
        compare(&image_tensor(&found), &expected, allowed)
    });
}
