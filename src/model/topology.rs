//! The network as a table of layers: the GPU planner, the CPU reference and the cost
//! counter all read this one description.

use super::operators::Op;

/// Names a tensor: 0 is the network's input, `i + 1` is what layer `i` makes.
pub type TensorId = usize;

/// The network's input as a tensor.
pub const INPUT: TensorId = 0;

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The name its weights have in the file, such as `enc_conv0a`.
    pub name: String,
    /// What it computes.
    pub op: Op,
    /// What it reads, in order.
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

/// A network: layers in an order in which each reads only what stands before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Network {
    /// The layers, first to last; the last one's output is the network's.
    pub layers: Vec<Layer>,
    /// The shape of every tensor, by [`TensorId`]; one more than there are layers.
    pub shapes: Vec<TensorShape>,
}

impl Network {
    /// The thesis network: per level two convolutions and a pool, two convolutions at the
    /// bottom, then per level a transposed convolution, the skip and two convolutions.
    /// `widths` are the channels of each encoder level and of the bottom.
    ///
    /// # Panics
    /// If `widths` is empty.
    #[must_use]
    pub fn unet(in_channels: usize, widths: &[usize]) -> Self {
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
        net.push("mid_convb".into(), conv, &[], *bottom);
        for (l, &width) in levels.iter().enumerate().rev() {
            let up = net.push(format!("dec_up{l}"), Op::ConvTranspose, &[], width);
            net.push(format!("concat{l}"), Op::Concat, &[skips[l], up], 2 * width);
            net.push(format!("dec_conv{l}a"), conv, &[], width);
            net.push(format!("dec_conv{l}b"), conv, &[], width);
        }
        net.push("out_conv".into(), Op::Conv1x1, &[], 3);
        net.push("sigmoid".into(), Op::Sigmoid, &[], 3);
        net
    }

    /// The tensor that the last layer makes.
    #[must_use]
    pub fn output(&self) -> TensorId {
        self.layers.len()
    }

    /// The network that ends after `count` layers.
    ///
    /// # Panics
    /// If there are fewer.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        Self { layers: self.layers[..count].to_vec(), shapes: self.shapes[..=count].to_vec() }
    }

    /// The network whose input is what the first layer made.
    ///
    /// # Panics
    /// If another layer reads the input, or there is no layer.
    #[must_use]
    pub fn behind_first(&self) -> Self {
        let behind = |id: &TensorId| id.checked_sub(1).expect("only the first reads the input");
        let mut layers = self.layers[1..].to_vec();
        for layer in &mut layers {
            layer.inputs = layer.inputs.iter().map(behind).collect();
        }
        Self { layers, shapes: self.shapes[1..].to_vec() }
    }

    /// Both sides of an image must be a multiple of this: `2^(number of poolings)`.
    #[must_use]
    pub fn alignment(&self) -> u32 {
        1 << self.shapes.iter().map(|s| s.level).max().unwrap_or(0)
    }

    pub(super) fn empty(in_channels: usize) -> Self {
        Self { layers: Vec::new(), shapes: vec![TensorShape { channels: in_channels, level: 0 }] }
    }

    /// Appends a layer that reads `inputs`, or the tensor before it if there are none named.
    pub(super) fn push(
        &mut self,
        name: String,
        op: Op,
        inputs: &[TensorId],
        channels: usize,
    ) -> TensorId {
        let before = self.output();
        let inputs = if inputs.is_empty() { vec![before] } else { inputs.to_vec() };
        let level = self.shapes[*inputs.last().expect("every layer reads something")].level;
        let level = level.saturating_add_signed(op.facts().level);
        self.layers.push(Layer { name, op, inputs });
        self.shapes.push(TensorShape { channels, level });
        self.output()
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
        assert_eq!(net.shapes[net.output()], TensorShape { channels: 3, level: 0 });
    }

    #[test]
    fn layers_read_only_what_stands_before_them() {
        let net = Network::unet(3, &[4, 6, 10]);
        for (i, layer) in net.layers.iter().enumerate() {
            assert!(layer.inputs.iter().all(|&t| t <= i), "{} reads the future", layer.name);
        }
    }
}
