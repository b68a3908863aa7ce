//! The U-Net of `weights-format.md`, in Burn.

use burn::tensor::activation::{relu, sigmoid};
use burn::tensor::module::{conv_transpose2d, conv2d, max_pool2d};
use burn::tensor::ops::{ConvOptions, ConvTransposeOptions, MaxPoolOptions};
use burn::tensor::{DType, Device, Tensor, TensorData};
use safetensors::SafeTensors;

use crate::Result;
use crate::weights::{self, Layer};

/// A convolution on the device.
struct Conv {
    weight: Tensor<4>,
    bias: Tensor<1>,
}

/// Two 3×3 convolutions, each with its ReLU.
struct Block([Conv; 2]);

pub struct UNet {
    encoder: Vec<Block>,
    middle: Block,
    /// From full resolution down, like the encoder.
    decoder: Vec<(Conv, Block)>,
    last: Conv,
}

impl UNet {
    /// Loads a network from a weights file, with batch norms folded into the convolutions.
    pub fn load(file: &[u8], dtype: DType, device: &Device) -> Result<Self> {
        let (widths, eps) = weights::metadata(file)?;
        let file = SafeTensors::deserialize(file)?;
        let conv = |name: &str| -> Result<Conv> {
            Ok(Conv::new(weights::layer(&file, name, eps)?, dtype, device))
        };
        let block = |name: &str| -> Result<Block> {
            Ok(Block([conv(&format!("{name}a"))?, conv(&format!("{name}b"))?]))
        };
        let levels = 0..widths.len() - 1;
        let up = |l| Ok((conv(&format!("dec_up{l}"))?, block(&format!("dec_conv{l}"))?));
        Ok(Self {
            encoder: levels
                .clone()
                .map(|l| block(&format!("enc_conv{l}")))
                .collect::<Result<_>>()?,
            middle: block("mid_conv")?,
            decoder: levels.map(up).collect::<Result<_>>()?,
            last: conv("out_conv")?,
        })
    }

    pub fn input_channels(&self) -> usize {
        self.encoder[0].0[0].weight.dims()[1]
    }

    pub fn forward(&self, mut x: Tensor<4>) -> Tensor<4> {
        let mut skips = Vec::new();
        for block in &self.encoder {
            let skip = block.forward(x);
            x = max_pool2d(skip.clone(), MaxPoolOptions::new([2, 2]));
            skips.push(skip);
        }
        x = self.middle.forward(x);
        for (up, block) in self.decoder.iter().rev() {
            let skip = skips.pop().expect("as many skips as levels");
            x = block.forward(Tensor::cat(vec![skip, up.double(x)], 1));
        }
        sigmoid(self.last.forward(x, 0))
    }
}

impl Block {
    fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        self.0.iter().fold(x, |x, conv| relu(conv.forward(x, 1)))
    }
}

impl Conv {
    fn new(layer: Layer, dtype: DType, device: &Device) -> Self {
        let bias_shape = [layer.bias.len()];
        let weight = Tensor::<4>::from_data(TensorData::new(layer.weight, layer.shape), device);
        let bias = Tensor::<1>::from_data(TensorData::new(layer.bias, bias_shape), device);
        Self { weight: weight.cast(dtype), bias: bias.cast(dtype) }
    }

    fn forward(&self, x: Tensor<4>, padding: usize) -> Tensor<4> {
        let options = ConvOptions::new([1, 1], [padding, padding], [1, 1], 1);
        conv2d(x, self.weight.clone(), Some(self.bias.clone()), options)
    }

    /// Applies the transposed convolution that doubles both sides.
    fn double(&self, x: Tensor<4>) -> Tensor<4> {
        let options = ConvTransposeOptions::new([2, 2], [0, 0], [0, 0], [1, 1], 1);
        conv_transpose2d(x, self.weight.clone(), Some(self.bias.clone()), options)
    }
}
