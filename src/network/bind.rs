//! Binds a network to images and to the textures of one tile size, which gives every call of a
//! frame.

use std::ops::Range;

use super::call::Call;
use super::compile::{BoxedOperator, CompiledNetwork, Ending, Stem};
use super::pyramid::Pyramid;
use crate::gpu::kernel::Context;
use crate::gpu::tensor::GpuTensor;
use crate::model::macs::layer_macs_per_pixel;
use crate::model::{INPUT, TensorId};
use crate::ops::activity::{Activity, activity};
use crate::ops::image::ImageBinding;
use crate::ops::input_process::{Sources, input_process};
use crate::ops::need::Need;
use crate::ops::operator::Io;
use crate::ops::output_process::{ResultImages, output_process};

/// The resources of a tile.
pub(crate) struct Bound<'a> {
    /// Size of the tiles, width first; multiples of the network's alignment.
    pub(crate) tile: [u32; 2],
    /// The images to read.
    pub(crate) sources: Sources<'a>,
    /// The image to write.
    pub(crate) output: ImageBinding<'a>,
    /// Uniform holding the share of noisy color in the result.
    pub(crate) blend: &'a wgpu::Buffer,
    /// Whether constant surroundings skip the network.
    pub(crate) skip_clean: bool,
    /// Further layers of the image. Only networks that predict a kernel pyramid take any.
    pub(crate) layers: &'a [BoundLayer<'a>],
}

impl<'a> Bound<'a> {
    fn result_images(&self) -> ResultImages<'a> {
        let Sources { tiles, input_scale, color, encoding, .. } = self.sources;
        ResultImages { tiles, input_scale, color, output: self.output, blend: self.blend, encoding }
    }
}

/// A further layer of the image, to be filtered with the kernels of its beauty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundLayer<'a> {
    /// [`Tile`](crate::ops::tile::Tile)s with the layouts of these images, at the same offsets as
    /// the beauty's.
    pub(crate) tiles: &'a wgpu::Buffer,
    /// The layer to read.
    pub(crate) color: ImageBinding<'a>,
    /// The image to write.
    pub(crate) output: ImageBinding<'a>,
    /// Whether it is light, which follows the texture of its surface, rather than data such as
    /// alpha.
    pub(crate) light: bool,
}

impl<'a> BoundLayer<'a> {
    /// The layer's images, in place of the beauty's.
    fn result_images(&self, bound: &Bound<'a>) -> ResultImages<'a> {
        let Self { tiles, color, output, .. } = *self;
        ResultImages { tiles, color, output, ..bound.result_images() }
    }
}

/// All calls of a tile.
#[derive(Debug)]
pub(crate) struct TileCalls {
    calls: Vec<Call>,
    batches: Vec<Range<usize>>,
    layers: Vec<Vec<Call>>,
}

/// Maximum multiply-accumulates of a submission of several calls: 0.2 s at 100 GFLOP/s. A single
/// call may have more, up to [`MACS_PER_DISPATCH`](crate::plan::tiles::MACS_PER_DISPATCH).
const MACS_PER_SUBMISSION: f64 = 10e9;

impl TileCalls {
    /// Creates the textures and binds the operators.
    pub(crate) fn new(context: &Context, network: &CompiledNetwork, bound: &Bound<'_>) -> Self {
        let Bound { tile, sources, .. } = bound;
        let tensors = tensors(context, network, *tile);
        let radius = network.reach.iter().copied().max().unwrap_or(0);
        let skips = bound.skip_clean && network.skips;
        let constant_radius = skips.then_some(network.constant_radius);
        let Sources { tiles, color, .. } = *sources;
        let (activity, activity_calls) =
            activity(context, tiles, color, *tile, radius, constant_radius);
        let mut calls = Vec::new();
        if !matches!(network.ending, Ending::Color) {
            calls.extend(activity_calls.map(|call| Call::per_tile("activity", call)));
        }
        calls.push(first_call(context, network, bound, &tensors[INPUT], &activity));
        calls.extend(layer_calls(context, network, *tile, &tensors, &activity));
        let (last, layers) = last_calls(context, network, bound, &tensors, &activity);
        calls.extend(last);
        let batches = batches(&calls.iter().map(|call| call.macs).collect::<Vec<_>>());
        Self { calls, batches, layers }
    }

    /// Records all calls for the tile at byte `offset` of the uniform buffer.
    pub(crate) fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        for call in self.calls.iter().chain(self.layers.iter().flatten()) {
            call.record_at(pass, offset);
        }
    }

    /// All calls in groups, each short enough for one submission.
    pub(crate) fn batches(&self) -> impl Iterator<Item = &[Call]> {
        self.batches.iter().map(|batch| &self.calls[batch.clone()])
    }

    /// The calls for the color, in order.
    pub(crate) fn calls(&self) -> &[Call] {
        &self.calls
    }

    /// The calls for each further layer. They come after those for the color.
    pub(crate) fn layers(&self) -> &[Vec<Call>] {
        &self.layers
    }
}

/// The call from the images to the first tensor.
fn first_call(
    context: &Context,
    network: &CompiledNetwork,
    bound: &Bound<'_>,
    tensor: &GpuTensor,
    activity: &Activity,
) -> Call {
    let Bound { tile, sources, .. } = bound;
    let Some(Stem { name, operator }) = &network.stem else {
        let call = Call::per_tile("input_process", input_process(context, sources, tensor));
        return call.moving(context, &[tensor], &[]).touching(*tile, &sources.present());
    };
    let need = Need { map: &activity.map, level: 0, reach: network.reach[INPUT] };
    let call = operator.dispatch(context, sources, tensor, &need);
    let macs = operator.macs_per_pixel() * f64::from(tile[0]) * f64::from(tile[1]);
    let call = Call::per_tile(&format!("input+{name}"), call).computing(macs);
    call.moving(context, &[tensor], &[]).touching(*tile, &sources.present())
}

/// The calls from the last tensors to the image, and to each further layer.
fn last_calls(
    context: &Context,
    network: &CompiledNetwork,
    bound: &Bound<'_>,
    tensors: &[GpuTensor],
    activity: &Activity,
) -> (Vec<Call>, Vec<Vec<Call>>) {
    let images = bound.result_images();
    let outputs: Vec<_> = network.body.outputs.iter().map(|&output| &tensors[output]).collect();
    let (name, dispatch, macs) = match &network.ending {
        &Ending::Pyramid { stores_level0 } => {
            let stores = stores_level0 || !bound.layers.is_empty();
            let albedo = bound.sources.albedo.filter(|_| network.demodulates);
            let pyramid = Pyramid::new(context, outputs, activity, stores, albedo);
            let layer = |layer: &BoundLayer<'_>| {
                pyramid.layer(&layer.result_images(bound), bound.sources.color, layer.light)
            };
            return (pyramid.image(&images), bound.layers.iter().map(layer).collect());
        }
        Ending::Color => ("output_process", output_process(context, outputs[0], &images), 0.0),
        Ending::Head(head) => {
            let dispatch = head.dispatch(context, outputs[0], activity, &images);
            ("head", dispatch, head.macs_per_pixel())
        }
    };
    let macs = macs * f64::from(bound.tile[0]) * f64::from(bound.tile[1]);
    let call = Call::per_tile(name, dispatch).computing(macs).moving(context, &outputs, &[]);
    (vec![call.touching(bound.tile, &[images.output])], Vec::new())
}

/// Views of new textures, by tensor.
fn tensors(context: &Context, network: &CompiledNetwork, tile: [u32; 2]) -> Vec<GpuTensor> {
    let slots =
        network.storage.slots.iter().map(|slot| {
            GpuTensor::texture(context, tile.map(|side| side >> slot.level), slot.quads)
        });
    let slots: Vec<_> = slots.collect();
    let tensor = |id: TensorId| {
        let place = network.storage.placements[id];
        GpuTensor::of(&slots[place.slot], place.first_quad, place.quads)
    };
    (0..network.storage.placements.len()).map(tensor).collect()
}

fn layer_calls(
    context: &Context,
    network: &CompiledNetwork,
    tile: [u32; 2],
    tensors: &[GpuTensor],
    activity: &Activity,
) -> Vec<Call> {
    let CompiledNetwork { body, operators, reach, .. } = network;
    let pixels = f64::from(tile[0]) * f64::from(tile[1]);
    let call = |(i, operator): (usize, &BoxedOperator)| {
        let layer = &body.layers[i];
        let inputs: Vec<_> = layer.inputs.iter().map(|&input| &tensors[input]).collect();
        let need =
            Need { map: &activity.map, level: body.shapes[i + 1].level, reach: reach[i + 1] };
        if i > 0 && operators[i - 1].pools() {
            return None;
        }
        let io = Io {
            inputs: &inputs,
            output: &tensors[i + 1],
            pooled: tensors.get(i + 2),
            need: Some(need),
        };
        let dispatch = operator.dispatch(&context.device, &io)?;
        let macs = layer_macs_per_pixel(body, i) * pixels;
        let pooled = io.pooled.filter(|_| operator.pools());
        let moved: Vec<_> = inputs.iter().copied().chain([io.output]).chain(pooled).collect();
        Some(Call::fixed(&layer.name, dispatch).computing(macs).moving(context, &moved, &[]))
    };
    operators.iter().enumerate().filter_map(call).collect()
}

/// Groups consecutive calls whose sum stays within the limit; a call above it gets its own group.
fn batches(macs: &[f64]) -> Vec<Range<usize>> {
    let mut batches = Vec::new();
    let (mut begin, mut sum) = (0, 0.0);
    for (i, macs) in macs.iter().enumerate() {
        if i > begin && sum + macs > MACS_PER_SUBMISSION {
            batches.push(begin..i);
            (begin, sum) = (i, 0.0);
        }
        sum += macs;
    }
    batches.push(begin..macs.len());
    batches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_every_call_once_and_stay_below_the_limit() {
        let macs = [1e9, 8e9, 2e9, 50e9, 1e9, 1e9];
        assert_eq!(batches(&macs), [0..2, 2..3, 3..4, 4..6]);
    }
}
