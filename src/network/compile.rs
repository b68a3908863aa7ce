//! Compiles a network: operators that are created once, for tiles of any size.

use super::pyramid;
use crate::error::{Error, Result};
use crate::gpu::kernel::Context;
use crate::gpu::kernel_set::KernelSet;
use crate::model::fuse::{Fused, HeadParams};
use crate::model::{Encoding, INPUT, Layer, Network, Op, Params, Weights};
use crate::ops;
use crate::ops::build::build;
use crate::ops::channel_map::{ChannelMap, channel_map};
use crate::ops::conv_logits;
use crate::ops::head::Head;
use crate::ops::input_conv::{self, InputConv};
use crate::ops::operator::{LayerRequest, Operator};
use crate::plan::{halo, storage::Storage};

/// A network with compiled kernels and uploaded weights.
#[derive(Debug)]
pub(crate) struct CompiledNetwork {
    /// All layers except the stem's and the head's.
    pub(crate) body: Network,
    /// The tensors that some kernel stores.
    pub(crate) storage: Storage,
    /// Tiles begin and end at multiples of this.
    pub(crate) alignment: u32,
    /// Overlap of tiles; see [`halo::halo`].
    pub(crate) halo: u32,
    /// Reach by tensor of the body; see [`halo::reach`].
    pub(crate) reach: Vec<u32>,
    /// How many blocks around a clean block must be constant; see [`halo::constant_radius`].
    pub(crate) constant_radius: u32,
    /// The encoding of the images.
    pub(crate) encoding: Encoding,
    /// The first layer, if one kernel computes it along with the encoding of the images.
    pub(crate) stem: Option<Stem>,
    /// Operators by layer.
    pub(crate) operators: Vec<BoxedOperator>,
    /// How the image is made from the body's outputs.
    pub(crate) ending: Ending,
    /// Whether the network demodulates and reads an albedo.
    pub(crate) demodulates: bool,
    /// Whether clean blocks can skip the network.
    pub(crate) skips: bool,
}

/// How the image is made from the last tensors.
#[derive(Debug)]
pub(crate) enum Ending {
    /// The tensor is the encoded color.
    Color,
    /// One kernel computes the last layers and the color.
    Head(Head),
    /// The tensors are the logits of a kernel pyramid.
    Pyramid {
        /// Whether level 0 is stored even without layers, which pays if memory is faster than
        /// arithmetic.
        stores_level0: bool,
    },
}

pub(crate) type BoxedOperator = Box<dyn Operator>;

/// The operator that encodes the images and computes the network's first layer.
#[derive(Debug)]
pub(crate) struct Stem {
    /// The layer's name.
    pub(crate) name: String,
    pub(crate) operator: InputConv,
}

impl Stem {
    /// The stem for the first layer of a network.
    fn new(
        context: &Context,
        kernels: KernelSet,
        network: &Network,
        params: impl Fn(&str) -> Params,
    ) -> Self {
        let name = network.layers[0].name.clone();
        let operator = InputConv::new(context, kernels, &params(&name));
        Self { name, operator }
    }
}

impl CompiledNetwork {
    /// Uploads the weights and compiles the layers' kernels. Kernels that read or write images
    /// depend on the formats and are compiled when bound.
    pub(crate) fn new(context: &Context, kernels: KernelSet, weights: &Weights) -> Result<Self> {
        if kernels == KernelSet::Plain {
            let (network, params) = (weights.network(), |layer: &str| weights.params(layer));
            return Self::build(context, kernels, weights, network, params, |_| {
                let pyramid = Ending::Pyramid { stores_level0: true };
                if network.has_pyramid() { pyramid } else { Ending::Color }
            });
        }
        let Fused { network, params, head } = Fused::new(weights, conv_logits::CHANNELS);
        let params = |layer: &str| params.get(layer).cloned().unwrap_or_default();
        Self::build(context, kernels, weights, &network, params, |map| {
            let Some(HeadParams { conv, sigmoid }) = &head else {
                let stores_level0 = kernels.resolve(&context.device) == KernelSet::Simd;
                return Ending::Pyramid { stores_level0 };
            };
            let mut head = Head::new(context, kernels, conv, map);
            head.sigmoid = *sigmoid;
            Ending::Head(head)
        })
    }

    /// `ending` receives how the last tensor is stored.
    fn build(
        context: &Context,
        kernels: KernelSet,
        weights: &Weights,
        network: &Network,
        params: impl Fn(&str) -> Params,
        ending: impl FnOnce(&ChannelMap) -> Ending,
    ) -> Result<Self> {
        let encoding = weights.metadata().encoding();
        let stem = input_conv::begins(network, encoding, kernels)
            .then(|| Stem::new(context, kernels, network, &params));
        let body = if stem.is_some() { network.behind_first() } else { network.clone() };
        let maps = channel_maps(&body, stem.is_some());
        let storage = Storage::plan(&body, maps[INPUT].len() as u32 / 4);
        check_layers(&storage, &context.device.limits())?;
        let alignment = network.alignment().max(halo::BLOCK);
        Ok(Self {
            alignment,
            halo: halo::halo(network).next_multiple_of(alignment),
            reach: halo::reach(network).split_off(usize::from(stem.is_some())),
            constant_radius: halo::constant_radius(network),
            encoding,
            operators: operators(context, kernels, &body, params, &maps),
            ending: ending(&maps[body.last()]),
            demodulates: network.demodulates() && weights.metadata().inputs.albedo,
            skips: kernels != KernelSet::Plain,
            stem,
            storage,
            body,
        })
    }

    /// GPU memory in bytes for everything but the images and weights, with or without further
    /// layers.
    pub(crate) fn bytes(&self, tile: [u32; 2], texel_bytes: u64, layers: bool) -> u64 {
        let pyramid = match self.ending {
            Ending::Pyramid { stores_level0 } => {
                let levels = self.body.outputs.len();
                pyramid::bytes(tile, levels, stores_level0 || layers, self.demodulates)
            }
            _ => 0,
        };
        let tensors = self.storage.bytes(tile[0], tile[1], texel_bytes);
        tensors + ops::activity::bytes(tile) + pyramid
    }
}

fn operators(
    context: &Context,
    kernels: KernelSet,
    network: &Network,
    params: impl Fn(&str) -> Params,
    maps: &[ChannelMap],
) -> Vec<BoxedOperator> {
    let operator = |(i, layer): (usize, &Layer)| {
        let maps: Vec<_> = layer.inputs.iter().map(|&input| &maps[input]).collect();
        let (params, next) = (&params(&layer.name), follows(network, i));
        build(layer.op, &LayerRequest { context, kernels, params, maps: &maps, next })
    };
    network.layers.iter().enumerate().map(operator).collect()
}

/// The layer right after `i`, if it reads the output of `i`.
fn follows(network: &Network, i: usize) -> Option<Op> {
    network.layers.get(i + 1).filter(|next| next.inputs == [i + 1]).map(|next| next.op)
}

fn check_layers(storage: &Storage, limits: &wgpu::Limits) -> Result<()> {
    let most = storage.slots.iter().map(|slot| slot.quads).max().unwrap_or(0);
    if most <= limits.max_texture_array_layers {
        return Ok(());
    }
    Err(Error::Budget(format!(
        "the widest tensor needs {most} array layers, but the device was created with {}; ask the \
         adapter for more (see required_limits) or use narrower weights",
        limits.max_texture_array_layers
    )))
}

/// How each tensor is stored. The input comes from a convolution if `convolved`, else from
/// `input_process`.
fn channel_maps(network: &Network, convolved: bool) -> Vec<ChannelMap> {
    let of_input = if convolved { channel_map } else { ops::input_process::channel_map };
    let mut maps = vec![of_input(network.shapes[INPUT].channels)];
    for (i, layer) in network.layers.iter().enumerate() {
        maps.push(if layer.op.facts().joins {
            ops::concat::channel_map(&maps[layer.inputs[0]], &maps[layer.inputs[1]])
        } else {
            channel_map(network.shapes[i + 1].channels)
        });
    }
    maps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::device::Gpu;
    use crate::gpu::precision::Precision;
    use crate::model::Quality;

    /// A kernel reads the number of its input's layers from the texture.
    #[test]
    fn every_tensor_has_as_many_layers_as_its_channels_need() {
        let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
        let weights = Weights::builtin(Quality::Balanced).expect("they are built in");
        for (kernels, stem) in [(KernelSet::Plain, false), (KernelSet::Tiled, true)] {
            let context = Context::new(&device, &queue, Precision::F16);
            let network = CompiledNetwork::new(&context, kernels, &weights).expect("it fits");
            assert_eq!(network.stem.is_some(), stem, "{kernels}");
            let maps = channel_maps(&network.body, stem);
            let expected: Vec<_> = maps.iter().map(|map| map.len() as u32 / 4).collect();
            let found: Vec<_> = network.storage.placements.iter().map(|p| p.quads).collect();
            assert_eq!(found, expected, "{kernels}");
        }
    }
}
