//! Finite weights can produce non-finite values when infinities of both signs meet in a sum.

use half::f16;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView, serialize};
use wgdenoise::internals::model::tza;
use wgdenoise::{Denoiser, Inputs, Options, Weights};

use crate::support::{frame, images};
use wgdenoise_testing::gpu::{gpu, variants};
use wgdenoise_testing::run_cases;

/// Networks that end in a sigmoid and in a ReLU, with the brightest exposed light that each
/// accepts.
fn networks() -> [(Vec<u8>, f32); 2] {
    let unet = include_bytes!("../fixtures/unet_tiny.safetensors").to_vec();
    let oidn = include_bytes!("../fixtures/oidn/rt_hdr_alb_nrm.tza");
    let oidn = tza::to_safetensors(oidn, "rt_hdr_alb_nrm").expect("the fixture is whole");
    [(unet, 65504.0), (oidn, 1e30)]
}

fn values(view: &TensorView<'_>) -> Vec<f32> {
    match view.dtype() {
        Dtype::F32 => view.data().as_chunks().0.iter().map(|&v| f32::from_le_bytes(v)).collect(),
        _ => view.data().as_chunks().0.iter().map(|&v| f16::from_le_bytes(v).to_f32()).collect(),
    }
}

/// The network with its convolution weights multiplied by `factor`.
pub(crate) fn times(file: &[u8], factor: f32) -> Weights {
    let tensors = SafeTensors::deserialize(file).expect("the fixture follows the format");
    let scaled = |name: &str, view: &TensorView<'_>| -> Vec<u8> {
        let factor = if name.contains(".norm.") { 1.0 } else { factor };
        values(view).into_iter().flat_map(|v| (v * factor).to_le_bytes()).collect()
    };
    let (_, header) = SafeTensors::read_metadata(file).expect("it was read");
    let all: Vec<_> =
        tensors.iter().map(|(name, v)| (name, v.shape().to_vec(), scaled(name, &v))).collect();
    let views = all.iter().map(|(name, shape, data)| {
        let view = TensorView::new(Dtype::F32, shape.clone(), data);
        (name.to_string(), view.expect("as many values as before"))
    });
    let bytes = serialize(views, header.metadata().clone()).expect("it fits");
    Weights::from_bytes(&bytes).expect("every value is finite")
}

#[test]
fn no_weights_make_a_pixel_that_is_no_number_or_brighter_than_what_goes_in() {
    let images = images(37, 22);
    let frame = frame(&images, Inputs::ALL);
    let frame = frame.input_scale(0.5);
    let networks = networks();
    let factors = |file| [1e8, 1e19, 1e36].map(|factor| (file, factor));
    let weights = networks.iter().flat_map(factors);
    let cases = weights.flat_map(|w| variants().into_iter().map(move |v| (w, v)));
    run_cases(cases, |&(((file, most), factor), (kernels, precision))| {
        let options = Options::default().kernels(kernels).precision(precision);
        let denoiser = Denoiser::new(&gpu().device, &gpu().queue, &times(file, factor), &options);
        let result = denoiser.expect("it fits").denoise(&frame).expect("it runs");
        // Leaves room for rounding in the inverse transfer function.
        let bad = |p: &&[f32; 3]| !p.iter().all(|v| (0.0..=most / 0.5 * 1.001).contains(v));
        match result.pixels().iter().filter(bad).count() {
            0 => Ok(()),
            count => Err(format!("{count} pixels, such as {:?}", result.pixels().iter().find(bad))),
        }
    });
}
