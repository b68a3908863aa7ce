//! The network as a table of layers, read by the GPU planner, the CPU reference and the cost
//! counter alike.

use super::operators::Op;

/// Identifies a tensor: 0 is the network's input, `i + 1` is the output of layer `i`.
pub type TensorId = usize;

/// The network's input as a tensor.
pub const INPUT: TensorId = 0;

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The name of its weights in the file, such as `enc_conv0a`.
    pub name: String,
    /// The operator.
    pub op: Op,
    /// The tensors it reads, in order.
    pub inputs: Vec<TensorId>,
}

/// Channels and resolution of a tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TensorShape {
    /// Number of channels.
    pub channels: usize,
    /// Both sides are the input's divided by `2^level`.
    pub level: u32,
}

/// A network: layers in execution order, each reading only earlier tensors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Network {
    /// The layers, first to last.
    pub layers: Vec<Layer>,
    /// The shape of every tensor, by [`TensorId`]; one more than the layers.
    pub shapes: Vec<TensorShape>,
    /// The tensors that the image is made from: the encoded color, or the logits of each level of a
    /// kernel pyramid, full resolution first.
    pub outputs: Vec<TensorId>,
}

/// Logits that a kernel pyramid reads per pixel: nine taps, confidence and share.
pub const LOGITS: usize = 11;

impl Network {
    /// The thesis network. Each encoder level has two convolutions and a pool, the bottom has two
    /// convolutions, and each decoder level has a transposed convolution, the skip and two
    /// convolutions. `widths` are the channels of each encoder level and of the bottom.
    ///
    /// # Panics
    /// Panics if `widths` is empty.
    #[must_use]
    pub fn unet(in_channels: usize, widths: &[usize]) -> Self {
        let mut net = Self::u_shape(in_channels, widths, |_, _, _| ());
        net.push("out_conv".into(), Op::Conv1x1, &[], 3);
        let color = net.push("sigmoid".into(), Op::Sigmoid, &[], 3);
        net.outputs = vec![color];
        net
    }

    /// The thesis network, predicting the weights of a kernel pyramid instead of color
    /// ([`reference::kernel_pyramid`](crate::internals::reference::kernel_pyramid)): each level
    /// ends in a 1×1 convolution to its logits. The bottom has no share.
    ///
    /// # Panics
    /// Panics if `widths` is empty.
    #[must_use]
    pub fn kernel_pyramid(in_channels: usize, widths: &[usize]) -> Self {
        let bottom = widths.len() - 1;
        let mut logits = vec![0; widths.len()];
        let mut net = Self::u_shape(in_channels, widths, |net, level, features| {
            let channels = if level == bottom { LOGITS - 1 } else { LOGITS };
            let name = format!("kernel_conv{level}");
            logits[level] = net.push(name, Op::Conv1x1, &[features], channels);
        });
        net.outputs = logits;
        net
    }

    /// The kernel pyramid with one more logit at full resolution. It gives the power of the
    /// albedo ratio that multiplies gathered light
    /// ([`reference::texture`](crate::internals::reference::texture)).
    #[must_use]
    pub fn demodulating(mut self) -> Self {
        self.shapes[self.outputs[0]].channels = LOGITS + 1;
        self
    }

    /// Whether gathered light is demodulated by the albedo.
    #[must_use]
    pub fn demodulates(&self) -> bool {
        self.has_pyramid() && self.shapes[self.outputs[0]].channels > LOGITS
    }

    /// Encoder, bottom and decoder. `ends` may append to the network after each level from the
    /// bottom up, given the level and its features.
    fn u_shape(
        in_channels: usize,
        widths: &[usize],
        mut ends: impl FnMut(&mut Self, usize, TensorId),
    ) -> Self {
        let conv = Op::Conv3x3 { relu: true };
        let mut net = Self::empty(in_channels);
        let (bottom, levels) = widths.split_last().expect("a network has at least one width");
        let mut skips = Vec::new();
        for (l, &width) in levels.iter().enumerate() {
            net.push(format!("enc_conv{l}a"), conv, &[], width);
            skips.push(net.push(format!("enc_conv{l}b"), conv, &[], width));
            net.push(format!("pool{l}"), Op::MaxPool, &[], width);
        }
        net.push("mid_conva".into(), conv, &[], *bottom);
        let mut features = net.push("mid_convb".into(), conv, &[], *bottom);
        ends(&mut net, levels.len(), features);
        for (l, &width) in levels.iter().enumerate().rev() {
            let up = net.push(format!("dec_up{l}"), Op::ConvTranspose, &[features], width);
            net.push(format!("concat{l}"), Op::Concat, &[skips[l], up], 2 * width);
            net.push(format!("dec_conv{l}a"), conv, &[], width);
            features = net.push(format!("dec_conv{l}b"), conv, &[], width);
            ends(&mut net, l, features);
        }
        net
    }

    /// The output of the last layer.
    #[must_use]
    pub fn last(&self) -> TensorId {
        self.layers.len()
    }

    /// Whether the image is made by a kernel pyramid.
    #[must_use]
    pub fn has_pyramid(&self) -> bool {
        self.outputs.len() > 1
    }

    /// The network cut off after `count` layers. The last one's output becomes its only output.
    ///
    /// # Panics
    /// Panics if it has fewer layers.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        let (layers, shapes) = (self.layers[..count].to_vec(), self.shapes[..=count].to_vec());
        Self { layers, shapes, outputs: vec![count] }
    }

    /// The network without its first layer, whose output becomes the input.
    ///
    /// # Panics
    /// Panics if another layer reads the input, or if the network has no layer.
    #[must_use]
    pub fn behind_first(&self) -> Self {
        let behind = |id: &TensorId| id.checked_sub(1).expect("only the first reads the input");
        let mut layers = self.layers[1..].to_vec();
        for layer in &mut layers {
            layer.inputs = layer.inputs.iter().map(behind).collect();
        }
        let outputs = self.outputs.iter().map(behind).collect();
        Self { layers, shapes: self.shapes[1..].to_vec(), outputs }
    }

    /// The number that both sides of an image must be multiples of: `2^(number of poolings)`.
    #[must_use]
    pub fn alignment(&self) -> u32 {
        1 << self.shapes.iter().map(|s| s.level).max().unwrap_or(0)
    }

    pub(super) fn empty(in_channels: usize) -> Self {
        let input = TensorShape { channels: in_channels, level: 0 };
        Self { layers: Vec::new(), shapes: vec![input], outputs: vec![INPUT] }
    }

    /// Appends a layer that reads `inputs`, or the previous tensor if `inputs` is empty.
    pub(super) fn push(
        &mut self,
        name: String,
        op: Op,
        inputs: &[TensorId],
        channels: usize,
    ) -> TensorId {
        let before = self.last();
        let inputs = if inputs.is_empty() { vec![before] } else { inputs.to_vec() };
        let level = self.shapes[*inputs.last().expect("every layer reads something")].level;
        let level = level.saturating_add_signed(op.facts().level);
        self.layers.push(Layer { name, op, inputs });
        self.shapes.push(TensorShape { channels, level });
        self.last()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thesis_network_has_the_layers_and_levels_of_the_paper() {
        let net = Network::unet(9, &[8, 16, 32, 64, 128]);
        let convs = net.layers.iter().filter(|l| matches!(l.op, Op::Conv3x3 { .. })).count();
        assert_eq!((convs, net.layers.len(), net.alignment()), (18, 18 + 4 + 4 + 4 + 2, 16));
        assert_eq!(net.shapes[net.outputs[0]], TensorShape { channels: 3, level: 0 });
    }

    #[test]
    fn a_kernel_pyramid_reads_logits_of_every_level_and_only_the_bottom_has_no_share() {
        let net = Network::kernel_pyramid(9, &[8, 16, 32, 64, 128]);
        let shape = |&id: &TensorId| (net.shapes[id].channels, net.shapes[id].level);
        let expected = [(11, 0), (11, 1), (11, 2), (11, 3), (10, 4)];
        assert_eq!(net.outputs.iter().map(shape).collect::<Vec<_>>(), expected);
        let names = net.outputs.iter().map(|id| net.layers[id - 1].name.as_str());
        assert!(names.eq((0..5).map(|level| format!("kernel_conv{level}"))));
    }

    #[test]
    fn a_demodulating_network_has_a_logit_more_at_full_resolution() {
        let plain = Network::kernel_pyramid(9, &[4; 3]);
        let network = plain.clone().demodulating();
        assert_eq!([&plain, &network].map(Network::demodulates), [false, true]);
        let channels = network.outputs.iter().map(|&logits| network.shapes[logits].channels);
        assert_eq!(channels.collect::<Vec<_>>(), [12, 11, 10]);
        assert!(!Network::unet(12, &[4, 4]).demodulates());
    }

    #[test]
    fn layers_read_only_what_stands_before_them() {
        for net in [Network::unet(3, &[4, 6, 10]), Network::kernel_pyramid(3, &[4, 6, 10])] {
            for (i, layer) in net.layers.iter().enumerate() {
                assert!(layer.inputs.iter().all(|&t| t <= i), "{} reads the future", layer.name);
            }
        }
    }
}
