//! How rounding grows through the layers: each layer's result on the GPU against the reference's,
//! whose sums have 64 bits.

use wgdenoise::internals::model::{INPUT, Layer, Op};
use wgdenoise::internals::ops::build::build;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::need::{Need, everything};
use wgdenoise::internals::ops::operator::LayerRequest;
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Image, KernelSet, Precision, Weights};

use crate::gpu::{context, stored};
use crate::run::run_where;

/// A layer's name, and the root of the mean squared error of what it makes, relative to that of its
/// values.
pub type Growth = Vec<(String, f64)>;

/// The growth when a colour alone goes through the layers with tensors of this precision.
pub fn growth(weights: &Weights, color: &Image, precision: Precision) -> Growth {
    let weights = weights.for_inputs(Default::default()).expect("colour alone is known");
    let network = weights.network();
    let scale = reference::autoexposure(color);
    let input = reference::input_process(color, None, None, scale, network.alignment());
    let mut exact = vec![input.clone()];
    let mut found = vec![stored(&input, precision)];
    let mut growth = vec![("input".into(), difference(&found[INPUT], &exact[INPUT]))];
    for layer in &network.layers {
        exact.push(on_cpu(&weights, layer, &inputs(&exact, layer)));
        found.push(on_gpu(&weights, layer, &inputs(&found, layer), precision));
        let error = difference(&found[found.len() - 1], &exact[exact.len() - 1]);
        growth.push((layer.name.clone(), error));
    }
    growth
}

fn inputs<'a>(tensors: &'a [Tensor], layer: &Layer) -> Vec<&'a Tensor> {
    layer.inputs.iter().map(|&id| &tensors[id]).collect()
}

fn on_cpu(weights: &Weights, layer: &Layer, inputs: &[&Tensor]) -> Tensor {
    let params = || weights.params(&layer.name);
    match layer.op {
        Op::Conv3x3 { relu } => {
            reference::conv3x3(inputs[0], &params().weight, &params().bias, relu)
        }
        Op::MaxPool => reference::max_pool(inputs[0]),
        Op::ConvTranspose => reference::conv_transpose(inputs[0], &params().weight, &params().bias),
        Op::Upsample => reference::upsample(inputs[0]),
        Op::Concat => reference::concat(inputs[0], inputs[1]),
        Op::Conv1x1 => reference::conv1x1(inputs[0], &params().weight, &params().bias),
        Op::Sigmoid => reference::sigmoid(inputs[0]),
        Op::UpConv { .. } => unreachable!("no weights file has fused layers"),
    }
}

/// The layer's kernel on what the kernels before it made.
fn on_gpu(weights: &Weights, layer: &Layer, inputs: &[&Tensor], precision: Precision) -> Tensor {
    if layer.op == Op::Concat {
        return reference::concat(inputs[0], inputs[1]);
    }
    let context = context(precision);
    let params =
        if layer.op.has_weights() { weights.params(&layer.name) } else { Default::default() };
    let map = channel_map(inputs[0].channels);
    let (kernels, maps) = (KernelSet::Plain, &[&map][..]);
    let request = LayerRequest { context, kernels, params: &params, maps, next: None };
    let operator = build(layer.op, &request);
    let map_of_zero = everything(&context.device);
    let need = Need { map: &map_of_zero, level: 0, reach: u32::MAX };
    run_where(
        context,
        &*operator,
        &[(inputs[0], &map)],
        shape(layer.op, inputs[0], &params.bias),
        need,
    )
}

/// Channels, height and width of what a layer with this bias makes.
fn shape(op: Op, input: &Tensor, bias: &[f32]) -> [usize; 3] {
    let [height, width] = [input.height, input.width];
    match op {
        Op::MaxPool => [input.channels, height / 2, width / 2],
        Op::ConvTranspose => [bias.len(), height * 2, width * 2],
        Op::Upsample => [input.channels, height * 2, width * 2],
        Op::Sigmoid => [input.channels, height, width],
        _ => [bias.len(), height, width],
    }
}

fn difference(found: &Tensor, exact: &Tensor) -> f64 {
    let square = |v: f64| v * v;
    let pairs = found.data.iter().zip(&exact.data).map(|(&a, &b)| (f64::from(a), f64::from(b)));
    let error: f64 = pairs.clone().map(|(a, b)| square(a - b)).sum();
    (error / pairs.map(|(_, b)| square(b)).sum::<f64>()).sqrt()
}

/// By how much a value is rounded at most when it is stored: half a unit in the last place.
pub fn rounding(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f64::from(f32::EPSILON) / 2.0,
        Precision::F16 => 1.0 / 2048.0,
    }
}

/// Every layer adds its own rounding to what came in, as a random walk does, and passes that on at
/// about its size: four times the walk's length is allowed, at every layer.
#[test]
fn rounding_grows_no_faster_than_a_random_walk() {
    let weights = Weights::builtin(wgdenoise::Quality::Fast).expect("they are built in");
    for precision in [Precision::F32, Precision::F16] {
        for (name, color) in inputs_to_grow() {
            for (steps, (layer, error)) in (1..).zip(growth(&weights, &color, precision)) {
                let walk = f64::from(steps).sqrt() * rounding(precision);
                println!("{precision:?} {name}: {layer} {:.2}", error / walk);
                assert!(error <= 4.0 * walk, "{precision:?}, {name}, {layer}: {error:e}");
            }
        }
    }
}

/// A picture with noise, one that changes from black to the brightest with every pixel, and one whose
/// values have every size that 16-bit floats have.
pub fn inputs_to_grow() -> [(&'static str, Image); 3] {
    let case = |name: &str| {
        let case = super::cases::cases().into_iter().find(|case| case.name == name);
        case.expect("the case is in the table").color
    };
    [
        ("noise", super::cases::noisy()),
        ("checkerboard of 65504", case("checkerboard of 65504")),
        ("values of every size", case("noise from 2^-24 to 65504")),
    ]
}
