//! The whole network, layer by layer.

use super::tensor::Tensor;
use super::{
    concat, conv_logits, conv_transpose, conv1x1, conv3x3, max_pool, sigmoid, up_conv, upsample,
};
use crate::model::operators::for_each_operator;
use crate::model::{INPUT, Network, Op, Params};

/// Runs every layer of the table in order and returns the network's first output, which is the
/// only one if it is color.
///
/// `input` is `[c, h, w]` with the channels that the network reads, both sides multiples of
/// [`Network::alignment`]. `params` returns a layer's weight and bias by its name, with any
/// normalization folded in.
///
/// # Panics
/// Panics if the input or a layer's weights do not have the shape the network declares.
#[must_use]
pub fn run(network: &Network, params: impl Fn(&str) -> Params, input: &Tensor) -> Tensor {
    run_by(network, params, input, apply).swap_remove(0)
}

/// All outputs of the network, with every layer computed by `apply` from its operator, weights and
/// inputs.
///
/// # Panics
/// Panics like [`run`].
pub fn run_by(
    network: &Network,
    params: impl Fn(&str) -> Params,
    input: &Tensor,
    apply: impl Fn(Op, &Params, &[&Tensor]) -> Tensor,
) -> Vec<Tensor> {
    let mut tensors = vec![input.clone()];
    assert_eq!(input.channels, network.shapes[INPUT].channels, "channels of the network's input");
    for (layer, shape) in network.layers.iter().zip(&network.shapes[1..]) {
        let inputs: Vec<&Tensor> = layer.inputs.iter().map(|&id| &tensors[id]).collect();
        let weighted = layer.op.has_weights();
        let weights = if weighted { params(&layer.name) } else { Params::default() };
        let made = apply(layer.op, &weights, &inputs);
        let declared = (shape.channels, input.height >> shape.level, input.width >> shape.level);
        assert_eq!(made.shape(), declared, "shape of what {} makes", layer.name);
        tensors.push(made);
    }
    network.outputs.iter().map(|&output| tensors[output].clone()).collect()
}

macro_rules! define_apply {
    ($($(#[$doc:meta])* $module:ident: $variant:ident $({
        $($(#[$field_doc:meta])* $field:ident: $type:ty),*
    })? = $facts:expr;)*) => {
        /// The output of an operator for its inputs.
        ///
        /// # Panics
        /// Panics if the shapes do not match.
        #[must_use]
        pub fn apply(op: Op, params: &Params, inputs: &[&Tensor]) -> Tensor {
            match op {
                $(Op::$variant { $($($field),*)? } => {
                    $module::apply(params, inputs $($(, $field)*)?)
                })*
            }
        }
    };
}
for_each_operator!(define_apply);

#[cfg(test)]
mod tests {
    use super::*;

    const LN_3: f32 = 1.098_612_3;
    const KEEP: [f32; 9] = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    const DOUBLE: [f32; 9] = [0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0];
    /// The first channel plus ten times the second.
    #[rustfmt::skip]
    const JOIN: [f32; 18] = [
        0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0,
    ];

    /// Kernels that only multiply, with one channel everywhere.
    fn params(layer: &str) -> Params {
        let (weight, bias): (&[f32], &[f32]) = match layer {
            "enc_conv0a" => (&DOUBLE, &[0.0]),
            "mid_conva" => (&KEEP, &[-13.0]),
            "enc_conv0b" | "mid_convb" | "dec_conv0b" => (&KEEP, &[0.0]),
            "dec_up0" => (&[10.0; 4], &[0.0]),
            "dec_conv0a" => (&JOIN, &[-315.0]),
            "out_conv" => (&[LN_3, -LN_3, 0.0], &[0.0; 3]),
            _ => panic!("{layer} has no weights"),
        };
        Params { weight: weight.to_vec(), bias: bias.to_vec() }
    }

    #[test]
    fn every_layer_reads_what_the_table_says() {
        // An 8 is 16 in the skip and 16 − 13 = 3 at the bottom, which the upsampling spreads as 30
        // over its four pixels. 16 + 10 · 30 − 315 = 1, but next to it the skip is 0.
        let eight = |y, x| (y % 2, x % 2) == (1, 0);
        let input = Tensor::from_fn(1, 4, 2, |_, y, x| if eight(y, x) { 8.0 } else { 0.0 });
        let found = run(&Network::unet(1, &[1, 1]), params, &input);
        let expected = |c: usize, y, x| if eight(y, x) { [0.75, 0.25, 0.5][c] } else { 0.5 };
        for (found, expected) in found.data.iter().zip(Tensor::from_fn(3, 4, 2, expected).data) {
            assert!((found - expected).abs() < 1e-6, "found {found}, expected {expected}");
        }
        assert_eq!(found.shape(), (3, 4, 2));
    }

    #[test]
    #[should_panic(expected = "channels of the network's input")]
    fn an_input_with_too_many_channels_is_refused() {
        let _ = run(&Network::unet(1, &[1, 1]), params, &Tensor::new(2, 2, 2, vec![0.0; 8]));
    }
}
