//! Reads a weights file, taking out and checking its tensors one by one.

use std::collections::HashSet;

use safetensors::{Dtype, SafeTensorError, SafeTensors};

use super::fold::{BatchNorm, fold};
use super::metadata::{Metadata, Topology};
use super::operators::Axes;
use super::params::Params;
use super::shown::shown;
use super::topology::{LOGITS, Layer, Network};
use crate::error::{Error, Result};

/// Headers must be shorter than this. The largest network needs 30 KiB; the rest is room for
/// provenance.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// A weights file with the tensors that have not been read yet.
pub(super) struct WeightsFile<'a> {
    pub(super) metadata: Metadata,
    tensors: SafeTensors<'a>,
    unread: HashSet<String>,
}

impl<'a> WeightsFile<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self> {
        check_header(bytes)?;
        let not_safetensors = |e: SafeTensorError| {
            let message = format!("not a whole safetensors file: {}", shown(&e.to_string()));
            Error::Weights { message, source: Some(e.into()) }
        };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(not_safetensors)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(not_safetensors)?;
        let pairs = header.metadata().as_ref().ok_or_else(|| {
            Error::weights("the file has no `__metadata__`; see weights-format.md")
        })?;
        // The map's type depends on a feature of safetensors that other crates may enable.
        let pairs = pairs.iter().map(|(key, value)| (key.clone(), value.clone())).collect();
        let unread = tensors.names().into_iter().map(str::to_string).collect();
        Ok(Self { metadata: Metadata::parse(&pairs)?, tensors, unread })
    }

    /// Whether the network is a kernel pyramid that demodulates: its finest level has one more
    /// logit.
    pub(super) fn demodulates(&self) -> bool {
        let logits = self.tensors.tensor("kernel_conv0.bias");
        self.metadata.topology == Topology::KernelPyramid
            && logits.is_ok_and(|bias| bias.shape() == [LOGITS + 1])
    }

    /// Weight and bias of a layer, with its batch norm folded in.
    pub(super) fn layer(&mut self, network: &Network, index: usize) -> Result<Params> {
        let Layer { name, op, inputs } = &network.layers[index];
        let (input, output) =
            (network.shapes[inputs[0]].channels, network.shapes[index + 1].channels);
        let shape = match op.facts().weights {
            Some(Axes::OutputInput([height, width])) => [output, input, height, width],
            Some(Axes::InputOutput([height, width])) => [input, output, height, width],
            Some(Axes::Fused) | None => unreachable!("a file has no weights of {name}"),
        };
        let mut weight = self.take(&format!("{name}.weight"), &shape)?;
        let normed =
            op.facts().may_have_norm && self.unread.contains(&format!("{name}.norm.weight"));
        let biased = !normed || self.unread.contains(&format!("{name}.bias"));
        let mut bias = vec![0.0; output];
        if biased {
            bias = self.take(&format!("{name}.bias"), &[output])?;
        }
        if normed {
            self.fold_norm(name, &mut weight, &mut bias)?;
        }
        Ok(Params { weight, bias })
    }

    /// Rejects tensors that belong to no layer.
    pub(super) fn finish(self) -> Result<()> {
        let Some(name) = self.unread.iter().min() else { return Ok(()) };
        Err(Error::weights(format!(
            "tensor `{}` (one of {} such) belongs to no layer of widths {:?}; remove it or \
             correct the metadata",
            shown(name),
            self.unread.len(),
            self.metadata.widths
        )))
    }

    fn fold_norm(&mut self, layer: &str, weight: &mut [f32], bias: &mut [f32]) -> Result<()> {
        let eps = self.metadata.norm_eps.ok_or_else(|| {
            Error::weights(format!(
                "`{layer}` has a batch norm, but metadata `norm_eps` is missing"
            ))
        })?;
        let mut take = |part: &str| self.take(&format!("{layer}.norm.{part}"), &[bias.len()]);
        let (gamma, beta) = (take("weight")?, take("bias")?);
        let (mean, variance) = (take("running_mean")?, take("running_var")?);
        if let Some(o) = variance.iter().position(|&v| v < 0.0) {
            return Err(Error::weights(format!(
                "`{layer}.norm.running_var`[{o}] is {}, expected at least 0",
                variance[o]
            )));
        }
        let norm = BatchNorm { weight: &gamma, bias: &beta, mean: &mean, variance: &variance, eps };
        fold(weight, bias, &norm);
        finite(&format!("{layer}.weight with its norm folded in"), weight)?;
        finite(&format!("{layer}.bias with its norm folded in"), bias)
    }

    /// Reads a tensor as f32 and checks its name, shape, type and values.
    fn take(&mut self, name: &str, shape: &[usize]) -> Result<Vec<f32>> {
        let tensor = self.tensors.tensor(name).map_err(|_| {
            Error::weights(format!("tensor `{name}` is missing, expected shape {shape:?}"))
        })?;
        if tensor.shape() != shape {
            return Err(Error::weights(format!(
                "tensor `{name}` has shape {}, expected {shape:?}",
                shown(&format!("{:?}", tensor.shape()))
            )));
        }
        let values = match tensor.dtype() {
            Dtype::F32 => floats(tensor.data(), |[a, b, c, d]| f32::from_le_bytes([a, b, c, d])),
            Dtype::F16 => floats(tensor.data(), |b| half::f16::from_le_bytes(b).to_f32()),
            other => {
                return Err(Error::weights(format!(
                    "tensor `{name}` has type {other:?}, expected F16 or F32"
                )));
            }
        };
        finite(name, &values)?;
        self.unread.remove(name);
        Ok(values)
    }
}

/// Rejects a header that would take too long to parse, before parsing it.
fn check_header(bytes: &[u8]) -> Result<()> {
    match bytes.first_chunk().copied().map(u64::from_le_bytes) {
        Some(header @ MAX_HEADER_BYTES..) => Err(Error::weights(format!(
            "not a whole safetensors file: its header claims {header} bytes, but fewer than \
             {MAX_HEADER_BYTES} are accepted"
        ))),
        _ => Ok(()),
    }
}

/// Decodes byte by byte, as tensor data in a safetensors file may be unaligned.
fn floats<const N: usize>(data: &[u8], decode: impl Fn([u8; N]) -> f32) -> Vec<f32> {
    data.as_chunks().0.iter().map(|&bytes| decode(bytes)).collect()
}

fn finite(name: &str, values: &[f32]) -> Result<()> {
    let Some(i) = values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
    Err(Error::weights(format!(
        "tensor `{name}` has {} at element {i}, expected finite values",
        values[i]
    )))
}
