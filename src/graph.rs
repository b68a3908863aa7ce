//! The network on the GPU: its operators once, its textures and calls per tile size.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::kernel::{Context, Dispatch};
use crate::model::cost::layer_macs_per_pixel;
use crate::model::{INPUT, Layer, Network, Op, TensorId, Weights};
use crate::ops::{self, ChannelMap, GpuTensor, Operator, channel_map};
use crate::options::KernelSet;
use crate::plan::{halo::halo, storage::Storage};

/// A network whose kernels are compiled and whose weights are on the GPU.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) network: Network,
    pub(crate) storage: Storage,
    /// Overlap of tiles; see [`halo`].
    pub(crate) halo: u32,
    operators: Vec<BoxedOperator>,
}

type BoxedOperator = Box<dyn Operator>;

impl Model {
    /// Uploads the weights and compiles the kernels.
    pub(crate) fn new(context: &Context, kernels: KernelSet, weights: &Weights) -> Result<Self> {
        let network = weights.network().clone();
        let storage = Storage::plan(&network);
        check_layers(&storage, &context.device.limits())?;
        let maps = channel_maps(&network);
        let operator = |layer: &Layer| {
            let params = weights.params(&layer.name);
            ops::build(context, kernels, layer.op, &params, &maps[layer.inputs[0]])
        };
        let operators = network.layers.iter().map(operator).collect();
        let halo = halo(&network);
        Ok(Self { network, storage, halo, operators })
    }
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

/// The network bound to the textures of one tile size.
#[derive(Debug)]
pub(crate) struct TileGraph {
    pub(crate) input: GpuTensor,
    pub(crate) output: GpuTensor,
    dispatches: Vec<Dispatch>,
    batches: Vec<Range<usize>>,
}

/// Most multiply-accumulates of one submission of the blocking call: Windows takes a GPU that
/// does not answer for two seconds from its program, and this is half a second at 80 GFLOP/s.
const MACS_PER_SUBMISSION: f64 = 20e9;

impl TileGraph {
    /// Creates the textures; both sides of `tile` must be multiples of the alignment.
    pub(crate) fn new(context: &Context, model: &Model, tile: [u32; 2]) -> Self {
        let slots: Vec<_> = model
            .storage
            .slots
            .iter()
            .map(|slot| {
                GpuTensor::texture(context, tile.map(|side| side >> slot.level), slot.quads)
            })
            .collect();
        let tensor = |id: TensorId| {
            let place = model.storage.placements[id];
            GpuTensor::of(&slots[place.slot], place.first_quad, place.quads)
        };
        let tensors: Vec<_> = (0..model.network.shapes.len()).map(tensor).collect();
        let pixels = f64::from(tile[0]) * f64::from(tile[1]);
        let call = |(i, operator): (usize, &BoxedOperator)| {
            let input = &tensors[model.network.layers[i].inputs[0]];
            let dispatch = operator.dispatch(&context.device, input, &tensors[i + 1])?;
            Some((dispatch, layer_macs_per_pixel(&model.network, i) * pixels))
        };
        let calls = model.operators.iter().enumerate().filter_map(call);
        let (dispatches, macs): (Vec<_>, Vec<_>) = calls.unzip();
        let output = tensors[model.network.output()].clone();
        Self { input: tensors[INPUT].clone(), output, dispatches, batches: batches(&macs) }
    }

    /// Records the whole network, from `input` to `output`.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        for dispatch in &self.dispatches {
            dispatch.record(pass);
        }
    }

    /// The same calls in groups, each short enough for a submission of its own.
    pub(crate) fn batches(&self) -> impl Iterator<Item = &[Dispatch]> {
        self.batches.iter().map(|batch| &self.dispatches[batch.clone()])
    }
}

/// Consecutive calls whose sum stays below the limit; a call above it stands alone.
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
        let macs = [1e9, 18e9, 2e9, 50e9, 1e9, 1e9];
        assert_eq!(batches(&macs), [0..2, 2..3, 3..4, 4..6]);
    }
}
