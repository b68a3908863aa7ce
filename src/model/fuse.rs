//! Fuses layers that one kernel can compute, removing the tensors between them. Exact up to
//! rounding.

use std::collections::BTreeMap;

use super::operators::Op;
use super::params::Params;
use super::topology::{Layer, Network, TensorId, TensorShape};
use super::weights::Weights;

/// A network in which every layer is one kernel.
#[derive(Clone, Debug)]
pub struct Fused {
    /// The layers up to the head; every decoder level starts with an [`Op::UpConv`].
    pub network: Network,
    /// Weights and biases by layer.
    pub params: BTreeMap<String, Params>,
    /// The head, if the network's output is color.
    pub head: Option<HeadParams>,
}

/// The layers between the last 3×3 convolution and the decoding of the image.
#[derive(Clone, Debug)]
pub struct HeadParams {
    /// The 1×1 convolution, or the identity if the network has none.
    pub conv: Params,
    /// Whether a sigmoid follows. Otherwise decoding clamps the values.
    pub sigmoid: bool,
}

impl Fused {
    /// Fuses each upsampling, concat and 3×3 convolution, and splits off the head. The last two
    /// layers of a kernel pyramid become an [`Op::ConvLogits`] if they have at most `most_logits`
    /// channels in between.
    #[must_use]
    pub fn new(weights: &Weights, most_logits: usize) -> Self {
        let network = weights.network();
        let (body, head) = head(network, weights);
        let mut fused = Self {
            network: Network { layers: vec![], shapes: vec![network.shapes[0]], outputs: vec![] },
            params: BTreeMap::new(),
            head,
        };
        let mut place = vec![0; network.shapes.len()];
        let mut i = 0;
        while i < body.len() {
            let (layer, params, count) = up_conv(network, weights, i)
                .or_else(|| conv_logits(network, weights, i, most_logits))
                .unwrap_or_else(|| (body[i].clone(), weights.params(&body[i].name), 1));
            i += count;
            fused.push(layer, params, &place, network.shapes[i]);
            place[i] = fused.network.last();
        }
        fused.network.outputs = match &fused.head {
            Some(_) => vec![fused.network.last()],
            None => network.outputs.iter().map(|&output| place[output]).collect(),
        };
        fused
    }

    fn push(&mut self, mut layer: Layer, params: Params, place: &[TensorId], shape: TensorShape) {
        layer.inputs.iter_mut().for_each(|input| *input = place[*input]);
        self.params.insert(layer.name.clone(), params);
        self.network.layers.push(layer);
        self.network.shapes.push(shape);
    }
}

/// The layers before the head, and the head itself.
fn head<'a>(network: &'a Network, weights: &Weights) -> (&'a [Layer], Option<HeadParams>) {
    match &network.layers[..] {
        body if network.has_pyramid() => (body, None),
        [body @ .., conv, last] if (conv.op, last.op) == (Op::Conv1x1, Op::Sigmoid) => {
            (body, Some(HeadParams { conv: weights.params(&conv.name), sigmoid: true }))
        }
        body => {
            let channels = network.shapes[network.last()].channels;
            (body, Some(HeadParams { conv: Params::identity(channels, 1), sigmoid: false }))
        }
    }
}

/// A layer, its weights, and the number of layers it replaces.
type Replacement = (Layer, Params, usize);

/// Fuses the last two layers of a kernel pyramid, if `i` is the first of them.
fn conv_logits(network: &Network, weights: &Weights, i: usize, most: usize) -> Option<Replacement> {
    let [conv, logits] = &network.layers[i..] else { return None };
    let [before, between] = [conv.inputs[0], i + 1].map(|id| network.shapes[id].channels);
    let keeps = (conv.op, logits.op) == (Op::Conv3x3 { relu: true }, Op::Conv1x1);
    if !(network.has_pyramid() && keeps && before == between && between <= most) {
        return None;
    }
    let params = weights.params(&conv.name).followed_by(weights.params(&logits.name));
    let name = format!("{}+{}", conv.name, logits.name);
    Some((Layer { name, op: Op::ConvLogits, inputs: conv.inputs.clone() }, params, 2))
}

/// Fuses the three layers starting at `i` if they are an upsampling, a concat and a 3×3
/// convolution.
fn up_conv(network: &Network, weights: &Weights, i: usize) -> Option<Replacement> {
    let [up, concat, conv, ..] = &network.layers[i..] else { return None };
    let Op::Conv3x3 { relu } = conv.op else { return None };
    if concat.op != Op::Concat || concat.inputs[1] != i + 1 {
        return None;
    }
    let ups = network.shapes[i + 1].channels;
    let of_up = up.op.facts().upsampling?(&weights.params(&up.name), ups);
    let params = of_up.followed_by(weights.params(&conv.name));
    let op = Op::UpConv { ups, relu };
    let inputs = vec![concat.inputs[0], up.inputs[0]];
    Some((Layer { name: conv.name.clone(), op, inputs }, params, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unet() -> Weights {
        let bytes = include_bytes!("../../tests/fixtures/unet_tiny.safetensors");
        Weights::from_bytes(bytes).unwrap()
    }

    fn kernel_pyramid() -> Weights {
        let bytes = include_bytes!("../../tests/fixtures/kernel_tiny.safetensors");
        Weights::from_bytes(bytes).unwrap()
    }

    fn names(network: &Network) -> Vec<&str> {
        network.layers.iter().map(|layer| layer.name.as_str()).collect()
    }

    #[test]
    fn every_decoder_level_becomes_two_layers_and_the_head_splits_off() {
        let fused = Fused::new(&unet(), 16);
        let decoder = ["dec_conv1a", "dec_conv1b", "dec_conv0a", "dec_conv0b"];
        assert_eq!(names(&fused.network)[8..], decoder);
        let ups = fused.network.layers.iter().filter(|l| matches!(l.op, Op::UpConv { .. }));
        assert_eq!((ups.count(), fused.network.outputs), (2, vec![12]));
        let head = fused.head.unwrap();
        assert!(head.conv.bias.len() == 3 && head.sigmoid);
    }

    #[test]
    fn a_kernel_pyramid_ends_in_one_layer_if_that_holds_its_channels() {
        let weights = kernel_pyramid();
        let width = weights.metadata().widths[0];
        let last = ["dec_conv0a", "dec_conv0b+kernel_conv0"];
        let fused = Fused::new(&weights, width);
        assert!(fused.head.is_none());
        assert_eq!(names(&fused.network)[12..], last);
        let whole = Fused::new(&weights, width - 1);
        assert_eq!(names(&whole.network)[12..], ["dec_conv0a", "dec_conv0b", "kernel_conv0"]);
        let last = fused.network.layers.last().unwrap();
        let params = &fused.params[&last.name];
        assert_eq!((last.op, params.bias.len()), (Op::ConvLogits, width + 11));
        assert_eq!(params.weight.len(), 9 * width * width + 11 * width);
    }

    #[test]
    fn outputs_stay_the_logits_of_each_level() {
        for most in [0, 16] {
            let Fused { network, .. } = Fused::new(&kernel_pyramid(), most);
            let of_level = |&id: &TensorId| &network.layers[id - 1].name;
            let found: Vec<_> = network.outputs.iter().map(of_level).collect();
            assert!(found[0].ends_with("kernel_conv0"), "{found:?}");
            assert_eq!(found[1..], ["kernel_conv1", "kernel_conv2"]);
        }
    }

    #[test]
    fn a_network_of_oidn_has_16_convolutions_and_4_pools_and_its_head_changes_nothing() {
        let bytes = include_bytes!("../../tests/fixtures/oidn/rt_alb.tza");
        let fused = Fused::new(&Weights::from_tza(bytes, "rt_alb").unwrap(), 16);
        let is_up = |layer: &&Layer| matches!(layer.op, Op::UpConv { .. });
        let ups: Vec<_> = fused.network.layers.iter().filter(is_up).collect();
        let names: Vec<_> = ups.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!(names, ["dec_conv4a", "dec_conv3a", "dec_conv2a", "dec_conv1a"]);
        assert_eq!((fused.network.layers.len(), ups[3].inputs[0]), (16 + 4, 0));
        let head = fused.head.unwrap();
        assert_eq!(head.conv.weight, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(!head.sigmoid);
    }

    #[test]
    fn layers_read_the_same_tensors_as_before() {
        for weights in [unet(), kernel_pyramid()] {
            let fused = Fused::new(&weights, 16).network;
            let made_by = |network: &Network, tensor: TensorId| {
                tensor.checked_sub(1).map(|i| network.layers[i].name.clone())
            };
            let skip = fused.layers.iter().find(|l| l.name == "dec_conv0a").unwrap();
            let sources = skip.inputs.iter().map(|&t| made_by(&fused, t).unwrap());
            assert_eq!(sources.collect::<Vec<_>>(), ["enc_conv0b", "dec_conv1b"]);
        }
    }
}
