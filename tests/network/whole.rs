//! The blocking call compared with the reference.

use wgdenoise::internals::model::INPUT;
use wgdenoise::internals::reference;
use wgdenoise::internals::reference::Tensor;
use wgdenoise::{Inputs, KernelSet, Options, Precision, Weights};

use crate::support::{
    F32, SETS, denoiser, denoiser_of, encoded, expected, frame, images, run, same_bits, tiny,
    tiny_demodulation, tiny_kernels, tolerance,
};
use wgdenoise_testing::gpu::{context, convolution_tolerance, kernel_sets, variants};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

#[test]
fn every_variant_equals_the_reference_for_every_input_set() {
    let images = images(37, 22);
    for weights in [tiny(), tiny_kernels(), tiny_demodulation()] {
        let cases = SETS.iter().flat_map(|&set| variants().into_iter().map(move |v| (set, v)));
        run_cases(cases, |&(inputs, (kernels, precision))| {
            let frame = frame(&images, inputs);
            let options = Options::default().kernels(kernels).precision(precision);
            let found = denoiser_of(&weights, &options).denoise(&frame).expect("the frame is fine");
            let expected = expected(&weights, &frame);
            let scale = reference::autoexposure(frame.color);
            let allowed = tolerance(kernels, precision);
            compare(&encoded(&found, scale), &encoded(&expected, scale), allowed)
        });
    }
}

#[test]
fn absent_inputs_count_as_zeros() {
    run_cases(SETS, |&inputs| {
        let (all, sliced) = (tiny(), tiny().for_inputs(inputs).expect("a subset"));
        let mut random = Random::new(4);
        let cut = random.tensor(inputs.channels(), 24, 40);
        let kept = inputs.channels_of(Inputs::ALL);
        let zeros = Tensor::from_fn(9, 24, 40, |c, y, x| {
            kept.iter().position(|&k| k == c).map_or(0.0, |i| cut.at(i, y, x))
        });
        for kernels in kernel_sets(Precision::F32) {
            let few = first_layer(&sliced, kernels, &cut);
            let many = first_layer(&all, kernels, &zeros);
            // Matrices add several inputs at a time; their grouping depends on the number of
            // inputs. So does the divisor of the weights for 16-bit sums.
            let allowed = match kernels {
                KernelSet::Matrix(_) | KernelSet::Half => {
                    convolution_tolerance(9 * 9, (kernels, Precision::F32))
                }
                _ => Tolerance { absolute: 0.0, relative: 0.0 },
            };
            compare(&few, &many, allowed).map_err(|error| format!("{kernels:?}: {error}"))?;
        }
        Ok(())
    });
}

/// The only layer that reads the network's input.
fn first_layer(weights: &Weights, kernels: KernelSet, input: &Tensor) -> Tensor {
    use wgdenoise::internals::ops::{conv3x3::conv3x3, input_process::channel_map};
    let readers = weights.network().layers.iter().filter(|l| l.inputs.contains(&INPUT));
    assert_eq!(readers.map(|l| l.name.as_str()).collect::<Vec<_>>(), ["enc_conv0a"]);
    let params = weights.params("enc_conv0a");
    let (context, map) = (context(Precision::F32), channel_map(input.channels));
    let operator = conv3x3(context, kernels, &params, &map, true, false);
    let shape = [params.bias.len(), input.height, input.width];
    wgdenoise_testing::run::run(context, &operator, input, &map, shape)
}

#[test]
fn the_same_input_makes_the_same_bits_every_time() {
    let images = images(50, 41);
    let frame = frame(&images, Inputs::ALL);
    let first = run(&Options::default(), &frame);
    for _ in 0..3 {
        same_bits(&run(&Options::default(), &frame), &first).unwrap();
    }
}

#[test]
fn the_shape_of_a_workgroups_tile_changes_no_bit() {
    let images = images(70, 41);
    let frame = frame(&images, Inputs::ALL);
    let [square, wide] = [KernelSet::Tiled, KernelSet::Wide].map(|kernels| {
        let options = Options::default().kernels(kernels);
        denoiser_of(&tiny_kernels(), &options).denoise(&frame).expect("the frame is fine")
    });
    same_bits(&wide, &square).unwrap();
}

#[test]
fn an_input_scale_replaces_the_measured_exposure() {
    let images = images(37, 22);
    let frame = frame(&images, Inputs::ALL).input_scale(0.05);
    let options = Options::default().precision(Precision::F32);
    let found = run(&options, &frame);
    let expected = expected(&tiny(), &frame);
    compare(&encoded(&found, 0.05), &encoded(&expected, 0.05), F32).unwrap();
}

#[test]
fn frames_that_do_not_fit_together_are_refused() {
    let denoiser = denoiser(&Options::default());
    let (color, small) = (images(8, 8), images(8, 7));
    let frame = frame(&color, Inputs::default()).albedo(&small[1]);
    let error = denoiser.denoise(&frame).unwrap_err().to_string();
    assert!(error.contains("albedo is 8×7, but the color is 8×8"), "{error}");
    let frame = frame.albedo(None).input_scale(f32::NAN);
    let error = denoiser.denoise(&frame).unwrap_err().to_string();
    assert!(error.contains("input scale is NaN"), "{error}");
}
