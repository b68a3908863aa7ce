//! The network on the GPU: its operators once, its textures and calls per tile size.

use crate::kernel::{Context, Dispatch};
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
    pub(crate) fn new(context: &Context, kernels: KernelSet, weights: &Weights) -> Self {
        let network = weights.network.clone();
        let maps = channel_maps(&network);
        let operator = |layer: &Layer| {
            let params = weights.params(&layer.name);
            ops::build(context, kernels, layer.op, &params, &maps[layer.inputs[0]])
        };
        let operators = network.layers.iter().map(operator).collect();
        let (storage, halo) = (Storage::plan(&network), halo(&network));
        Self { network, storage, halo, operators }
    }
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
}

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
        let steps = model.network.layers.iter().zip(&model.operators).zip(&tensors[1..]);
        let call = |((layer, operator), output): ((&Layer, &BoxedOperator), &GpuTensor)| {
            operator.dispatch(&context.device, &tensors[layer.inputs[0]], output)
        };
        let dispatches = steps.filter_map(call).collect();
        let output = tensors[model.network.output()].clone();
        Self { input: tensors[INPUT].clone(), output, dispatches }
    }

    /// Records the whole network, from `input` to `output`.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        for dispatch in &self.dispatches {
            dispatch.record(pass);
        }
    }
}
