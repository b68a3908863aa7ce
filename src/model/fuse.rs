//! The network with fewer layers: what stands between two kernels that can be one is left out.
//! Exact up to rounding.

use std::collections::BTreeMap;

use super::operators::Op;
use super::params::Params;
use super::topology::{Layer, Network, TensorId, TensorShape};
use super::weights::Weights;

/// A network whose layers are each one kernel.
#[derive(Clone, Debug)]
pub struct Fused {
    /// The layers up to the last 3×3 convolution, each decoder level begun by an [`Op::UpConv`].
    pub network: Network,
    /// Weights and biases by layer.
    pub params: BTreeMap<String, Params>,
    /// What follows.
    pub head: HeadParams,
}

/// What stands between the last 3×3 convolution and the decoding of the image.
#[derive(Clone, Debug)]
pub struct HeadParams {
    /// Those of a 1×1 convolution: the identity where the network has none.
    pub conv: Params,
    /// Whether a sigmoid follows; if not, the values are clamped as they are decoded.
    pub sigmoid: bool,
}

impl Fused {
    /// Fuses upsampling, concat and 3×3 convolution, and takes off the head.
    #[must_use]
    pub fn new(weights: &Weights) -> Self {
        let network = weights.network();
        let (body, head) = head(network, weights);
        let mut fused = Self {
            network: Network { layers: Vec::new(), shapes: vec![network.shapes[0]] },
            params: BTreeMap::new(),
            head,
        };
        let mut place = vec![0; network.shapes.len()];
        let mut i = 0;
        while i < body.len() {
            let (layer, params, count) = match up_conv(network, weights, i) {
                Some((layer, params)) => (layer, params, 3),
                None => (body[i].clone(), weights.params(&body[i].name), 1),
            };
            i += count;
            fused.push(layer, params, &place, network.shapes[i]);
            place[i] = fused.network.output();
        }
        fused
    }

    fn push(&mut self, mut layer: Layer, params: Params, place: &[TensorId], shape: TensorShape) {
        layer.inputs.iter_mut().for_each(|input| *input = place[*input]);
        self.params.insert(layer.name.clone(), params);
        self.network.layers.push(layer);
        self.network.shapes.push(shape);
    }
}

/// The layers before the head, and the head.
fn head<'a>(network: &'a Network, weights: &Weights) -> (&'a [Layer], HeadParams) {
    match &network.layers[..] {
        [body @ .., conv, last] if (conv.op, last.op) == (Op::Conv1x1, Op::Sigmoid) => {
            (body, HeadParams { conv: weights.params(&conv.name), sigmoid: true })
        }
        body => {
            let channels = network.shapes[network.output()].channels;
            (body, HeadParams { conv: Params::identity(channels, 1), sigmoid: false })
        }
    }
}

/// The three layers from `i` on as one, if they are an upsampling, concat and 3×3 convolution.
fn up_conv(network: &Network, weights: &Weights, i: usize) -> Option<(Layer, Params)> {
    let [up, concat, conv, ..] = &network.layers[i..] else { return None };
    let Op::Conv3x3 { relu } = conv.op else { return None };
    if concat.op != Op::Concat || concat.inputs[1] != i + 1 {
        return None;
    }
    let ups = network.shapes[i + 1].channels;
    let mut params = up.op.facts().upsampling?(&weights.params(&up.name), ups);
    let of_conv = weights.params(&conv.name);
    let op = Op::UpConv { ups, relu };
    params.weight.extend(of_conv.weight);
    params.bias.extend(of_conv.bias);
    let inputs = vec![concat.inputs[0], up.inputs[0]];
    Some((Layer { name: conv.name.clone(), op, inputs }, params))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Quality;

    #[test]
    fn the_thesis_network_has_18_convolutions_and_4_pools() {
        let fused = Fused::new(&Weights::builtin(Quality::Fast).unwrap());
        let count = |op: fn(Op) -> bool| fused.network.layers.iter().filter(|l| op(l.op)).count();
        assert_eq!(count(|op| matches!(op, Op::Conv3x3 { .. })), 14);
        assert_eq!(count(|op| matches!(op, Op::UpConv { .. })), 4);
        assert_eq!(count(|op| op == Op::MaxPool), 4);
        assert_eq!(fused.network.layers.len(), 22);
        assert!(fused.head.conv.bias.len() == 3 && fused.head.sigmoid);
    }

    #[test]
    fn a_network_of_oidn_has_16_convolutions_and_4_pools_and_its_head_changes_nothing() {
        let bytes = include_bytes!("../../tests/fixtures/oidn/rt_alb.tza");
        let fused = Fused::new(&Weights::from_tza(bytes, "rt_alb").unwrap());
        let is_up = |layer: &&Layer| matches!(layer.op, Op::UpConv { .. });
        let ups: Vec<_> = fused.network.layers.iter().filter(is_up).collect();
        let names: Vec<_> = ups.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!(names, ["dec_conv4a", "dec_conv3a", "dec_conv2a", "dec_conv1a"]);
        assert_eq!((fused.network.layers.len(), ups[3].inputs[0]), (16 + 4, 0));
        assert_eq!(fused.head.conv.weight, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(!fused.head.sigmoid);
    }

    #[test]
    fn layers_read_the_same_tensors_as_before() {
        let weights = Weights::builtin(Quality::Fast).unwrap();
        let fused = Fused::new(&weights).network;
        let made_by = |network: &Network, tensor: TensorId| {
            tensor.checked_sub(1).map(|i| network.layers[i].name.clone())
        };
        let skip = fused.layers.iter().find(|l| l.name == "dec_conv1a").unwrap();
        let sources: Vec<_> = skip.inputs.iter().map(|&t| made_by(&fused, t).unwrap()).collect();
        assert_eq!(sources, ["enc_conv1b", "dec_conv2b"]);
    }
}
