//! How rounding error grows through the layers: compares each layer's GPU result with the
//! reference, which sums in 64 bits.

use wgdenoise::internals::model::{INPUT, Layer, Op, Params};
use wgdenoise::internals::ops::build::build;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::need::{Need, everything};
use wgdenoise::internals::ops::operator::LayerRequest;
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Image, KernelSet, Precision, Weights};

use crate::gpu::{context, stored};
use crate::run::run_where;

/// A layer's name and the RMS error of its output, relative to the output's RMS.
pub type Growth = Vec<(String, f64)>;

/// The growth for a color-only input, with tensors of this precision.
pub fn growth(weights: &Weights, color: &Image, precision: Precision) -> Growth {
    let weights = weights.for_inputs(Default::default()).expect("color alone is known");
    let network = weights.network();
    let scale = reference::autoexposure(color);
    let input = reference::input_process(color, None, None, scale, network.alignment());
    let mut exact = vec![input.clone()];
    let mut found = vec![stored(&input, precision)];
    let mut growth = vec![("input".into(), difference(&found[INPUT], &exact[INPUT]))];
    for layer in &network.layers {
        let params = weights.params(&layer.name);
        exact.push(reference::apply(layer.op, &params, &inputs(&exact, layer)));
        let made = exact[exact.len() - 1].shape();
        found.push(on_gpu(layer.op, &params, &inputs(&found, layer), made, precision));
        let error = difference(&found[found.len() - 1], &exact[exact.len() - 1]);
        growth.push((layer.name.clone(), error));
    }
    growth
}

fn inputs<'a>(tensors: &'a [Tensor], layer: &Layer) -> Vec<&'a Tensor> {
    layer.inputs.iter().map(|&id| &tensors[id]).collect()
}

/// Runs the layer's kernel on the previous kernels' output, for a result of this shape.
fn on_gpu(
    op: Op,
    params: &Params,
    inputs: &[&Tensor],
    (channels, height, width): (usize, usize, usize),
    precision: Precision,
) -> Tensor {
    if op.facts().joins {
        return reference::apply(op, params, inputs);
    }
    let context = context(precision);
    let map = channel_map(inputs[0].channels);
    let (kernels, maps) = (KernelSet::Plain, &[&map][..]);
    let operator = build(op, &LayerRequest { context, kernels, params, maps, next: None });
    let map_of_zero = everything(&context.device);
    let need = Need { map: &map_of_zero, level: 0, reach: u32::MAX };
    run_where(context, &*operator, &[(inputs[0], &map)], [channels, height, width], need)
}

fn difference(found: &Tensor, exact: &Tensor) -> f64 {
    let square = |v: f64| v * v;
    let pairs = found.data.iter().zip(&exact.data).map(|(&a, &b)| (f64::from(a), f64::from(b)));
    let error: f64 = pairs.clone().map(|(a, b)| square(a - b)).sum();
    (error / pairs.map(|(_, b)| square(b)).sum::<f64>()).sqrt()
}

/// The maximum rounding error of a stored value: half a unit in the last place.
pub fn rounding(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f64::from(f32::EPSILON) / 2.0,
        Precision::F16 => 1.0 / 2048.0,
    }
}

/// A noisy image, one that alternates between black and the brightest value at every pixel, and one
/// with values of every magnitude of 16-bit floats.
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
