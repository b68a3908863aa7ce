//! The network on the GPU: its operators once, its textures and calls per tile size.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::kernel::{Context, Dispatch};
use crate::model::cost::layer_macs_per_pixel;
use crate::model::fuse::Fused;
use crate::model::{INPUT, Network, Op, Params, TensorId, Weights};
use crate::ops::activity::{Activity, activity};
use crate::ops::head::{Head, Images};
use crate::ops::input_process::{Sources, input_process};
use crate::ops::need::Need;
use crate::ops::output_process::output_process;
use crate::ops::{self, ChannelMap, GpuTensor, Io, Operator, channel_map};
use crate::options::{KernelSet, Options};
use crate::plan::{halo, storage::Storage};

/// A network whose kernels are compiled and whose weights are on the GPU.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) network: Network,
    pub(crate) storage: Storage,
    /// Tiles begin and end at multiples of this.
    pub(crate) alignment: u32,
    /// Overlap of tiles; see [`halo::halo`].
    pub(crate) halo: u32,
    /// By tensor, see [`halo::reach`].
    reach: Vec<u32>,
    operators: Vec<BoxedOperator>,
    /// The last layers, if they are one kernel.
    head: Option<Head>,
}

type BoxedOperator = Box<dyn Operator>;

impl Model {
    /// Uploads the weights and compiles the kernels.
    pub(crate) fn new(context: &Context, options: &Options, weights: &Weights) -> Result<Self> {
        let kernels = options.kernels;
        if kernels == KernelSet::Plain {
            let network = weights.network().clone();
            return Self::build(context, kernels, network, |layer| weights.params(layer), None);
        }
        let Fused { network, params, head } = Fused::new(weights);
        let params = |layer: &str| params.get(layer).cloned().unwrap_or_default();
        Self::build(context, kernels, network, params, Some(&head))
    }

    fn build(
        context: &Context,
        kernels: KernelSet,
        network: Network,
        params: impl Fn(&str) -> Params,
        head: Option<&Params>,
    ) -> Result<Self> {
        let storage = Storage::plan(&network);
        check_layers(&storage, &context.device.limits())?;
        let maps = channel_maps(&network);
        let mut operators = Vec::new();
        for (i, layer) in network.layers.iter().enumerate() {
            let (op, params) = (layer.op, params(&layer.name));
            let maps: Vec<_> = layer.inputs.iter().map(|&input| &maps[input]).collect();
            let pools = follows(&network, i) == Some(Op::MaxPool);
            operators.push(ops::build(context, kernels, op, &params, &maps, pools));
        }
        let head = head.map(|head| Head::new(context, kernels, head, &maps[network.output()]));
        let alignment = network.alignment().max(halo::BLOCK);
        let reach = halo::reach(&network);
        let halo = halo::halo(&network).next_multiple_of(alignment);
        Ok(Self { network, storage, alignment, halo, reach, operators, head })
    }

    /// GPU memory for everything between the images, in bytes.
    pub(crate) fn bytes(&self, tile: [u32; 2], texel_bytes: u64) -> u64 {
        self.storage.bytes(tile[0], tile[1], texel_bytes) + ops::activity::bytes(tile)
    }
}

/// The layer right after `i`, if it reads what that makes.
fn follows(network: &Network, i: usize) -> Option<Op> {
    network.layers.get(i + 1).filter(|next| next.inputs == [i + 1]).map(|next| next.op)
}

fn check_layers(storage: &Storage, limits: &wgpu::Limits) -> Result<()> {
    let most = storage.slots.iter().map(|slot| slot.quads).max().unwrap_or(0);
    if most <= limits.max_texture_array_layers {
        return Ok(());
    }
    Err(Error::Weights(format!(
        "the widest tensor needs {most} array layers, but the device was created with {}; ask the \
         adapter for more (see required_limits) or use narrower weights",
        limits.max_texture_array_layers
    )))
}

/// How each tensor is stored.
fn channel_maps(network: &Network) -> Vec<ChannelMap> {
    let mut maps = vec![ops::input_process::channel_map(network.shapes[INPUT].channels)];
    for (i, layer) in network.layers.iter().enumerate() {
        maps.push(match layer.op {
            Op::Concat => ops::concat::channel_map(&maps[layer.inputs[0]], &maps[layer.inputs[1]]),
            _ => channel_map(network.shapes[i + 1].channels),
        });
    }
    maps
}

/// One kernel call of a tile.
#[derive(Debug)]
pub(crate) struct Call {
    /// The layer's name, or the operator's.
    pub(crate) name: String,
    /// Multiply-accumulates.
    pub(crate) macs: f64,
    /// Bytes of the tensors that it reads and writes.
    pub(crate) bytes: f64,
    dispatch: Dispatch,
    /// Whether it reads the tile's uniform.
    per_tile: bool,
}

impl Call {
    /// Records the call for the tile at `offset` bytes of the uniform.
    pub(crate) fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        if self.per_tile {
            self.dispatch.record_at(pass, offset);
        } else {
            self.dispatch.record(pass);
        }
    }
}

/// The network bound to the textures of one tile size and to images.
#[derive(Debug)]
pub(crate) struct TileGraph {
    calls: Vec<Call>,
    batches: Vec<Range<usize>>,
}

/// Most multiply-accumulates of one submission of the blocking call: Windows takes a GPU that
/// does not answer for two seconds from its program, and this is half a second at 80 GFLOP/s.
const MACS_PER_SUBMISSION: f64 = 20e9;

impl TileGraph {
    /// Creates the textures; both sides of `tile` must be multiples of the alignment.
    pub(crate) fn new(
        context: &Context,
        model: &Model,
        tile: [u32; 2],
        skip_clean: bool,
        sources: &Sources<'_>,
        output: &wgpu::Buffer,
    ) -> Self {
        let tensors = tensors(context, model, tile);
        let radius = model.reach.iter().copied().max().unwrap_or(0);
        let skip = skip_clean && model.head.is_some();
        let (activity, activity_calls) = activity(context, sources, tile, radius, skip);
        let per_tile = |name: &str, dispatch| Call {
            name: name.into(),
            macs: 0.0,
            bytes: 0.0,
            dispatch,
            per_tile: true,
        };
        let mut calls = Vec::new();
        if model.head.is_some() {
            calls.extend(activity_calls.map(|call| per_tile("activity", call)));
        }
        calls.push(per_tile("input_process", input_process(context, sources, &tensors[INPUT])));
        calls.extend(layer_calls(context, model, tile, &tensors, &activity));
        let last = &tensors[model.network.output()];
        calls.push(match &model.head {
            Some(head) => {
                let Sources { tiles, input_scale, color, .. } = *sources;
                let images = Images { tiles, input_scale, color, output };
                per_tile("head", head.dispatch(&context.device, last, &activity, &images))
            }
            None => {
                let Sources { tiles, input_scale, .. } = *sources;
                let call = output_process(context, tiles, last, input_scale, output);
                per_tile("output_process", call)
            }
        });
        let batches = batches(&calls);
        Self { calls, batches }
    }

    /// Records everything for the tile at `offset` bytes of the uniform.
    pub(crate) fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        self.calls.iter().for_each(|call| call.record_at(pass, offset));
    }

    /// The same calls in groups, each short enough for a submission of its own.
    pub(crate) fn batches(&self) -> impl Iterator<Item = &[Call]> {
        self.batches.iter().map(|batch| &self.calls[batch.clone()])
    }

    /// All calls in order.
    pub(crate) fn calls(&self) -> &[Call] {
        &self.calls
    }
}

/// Views of new textures, by tensor.
fn tensors(context: &Context, model: &Model, tile: [u32; 2]) -> Vec<GpuTensor> {
    let slots =
        model.storage.slots.iter().map(|slot| {
            GpuTensor::texture(context, tile.map(|side| side >> slot.level), slot.quads)
        });
    let slots: Vec<_> = slots.collect();
    let tensor = |id: TensorId| {
        let place = model.storage.placements[id];
        GpuTensor::of(&slots[place.slot], place.first_quad, place.quads)
    };
    (0..model.network.shapes.len()).map(tensor).collect()
}

fn layer_calls(
    context: &Context,
    model: &Model,
    tile: [u32; 2],
    tensors: &[GpuTensor],
    activity: &Activity,
) -> Vec<Call> {
    let Model { network, operators, reach, .. } = model;
    let pixels = f64::from(tile[0]) * f64::from(tile[1]);
    let call = |(i, operator): (usize, &BoxedOperator)| {
        let layer = &network.layers[i];
        let inputs: Vec<_> = layer.inputs.iter().map(|&input| &tensors[input]).collect();
        let need =
            Need { map: &activity.map, level: network.shapes[i + 1].level, reach: reach[i + 1] };
        if i > 0 && operators[i - 1].pools() {
            return None;
        }
        let io = Io { inputs: &inputs, output: &tensors[i + 1], pooled: tensors.get(i + 2), need };
        let dispatch = operator.dispatch(&context.device, &io)?;
        let macs = layer_macs_per_pixel(network, i) * pixels;
        let tensors = inputs.iter().copied().chain([io.output]);
        let bytes = tensors.map(|tensor| tensor.bytes(context.precision)).sum();
        Some(Call { name: layer.name.clone(), macs, bytes, dispatch, per_tile: false })
    };
    operators.iter().enumerate().filter_map(call).collect()
}

/// Consecutive calls whose sum stays below the limit; a call above it stands alone.
fn batches(calls: &[Call]) -> Vec<Range<usize>> {
    split(&calls.iter().map(|call| call.macs).collect::<Vec<_>>())
}

fn split(macs: &[f64]) -> Vec<Range<usize>> {
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
        let macs = [1e9, 18e9, 2e9, 50e9, 1e9, 1e9];
        assert_eq!(split(&macs), [0..2, 2..3, 3..4, 4..6]);
    }
}
