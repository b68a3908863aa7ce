//! A weights file, checked and folded. `weights-format.md` is the normative text.

use std::collections::BTreeMap;

use super::file::WeightsFile;
use super::inputs::Inputs;
use super::macs::macs_per_pixel;
use super::metadata::{Metadata, Topology};
use super::operators::{Axes, Op};
use super::params::Params;
use super::topology::{Layer, Network};
use super::tza;
use crate::error::{Error, Result};

/// A network with all its weights.
#[derive(Clone, Debug)]
pub struct Weights {
    metadata: Metadata,
    network: Network,
    params: BTreeMap<String, Params>,
}

/// How much work is spent: which of the built-in weights. Widths and errors are in
/// `weights/README.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Least time: the thesis network with 8 base channels, 12 kMAC per pixel.
    Fast,
    /// The thesis network with 16 base channels, 47 kMAC per pixel.
    #[default]
    Balanced,
    /// Least error: twice the channels at full and half resolution, 124 kMAC per pixel.
    High,
}

impl Quality {
    /// All of them, by rising cost.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Balanced, Self::High];

    /// Those whose weights are built in, by rising cost: each is a feature of the crate.
    #[must_use]
    pub fn built_in() -> Vec<Self> {
        let has = |quality: &Self| match quality {
            Self::Fast => cfg!(feature = "fast"),
            Self::Balanced => cfg!(feature = "balanced"),
            Self::High => cfg!(feature = "high"),
        };
        Self::ALL.into_iter().filter(has).collect()
    }

    /// As on the command line: `fast`, `balanced` or `high`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::High => "high",
        }
    }

    /// The next that costs less.
    #[must_use]
    pub fn cheaper(self) -> Option<Self> {
        match self {
            Self::Fast => None,
            Self::Balanced => Some(Self::Fast),
            Self::High => Some(Self::Balanced),
        }
    }
}

impl Weights {
    /// Reads a weights file of format version 1.
    ///
    /// # Errors
    /// If the file is not safetensors, its metadata is not of this format, a tensor is
    /// missing, unknown, of a wrong shape or type, or a value is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut file = WeightsFile::open(bytes)?;
        let metadata = file.metadata.clone();
        let network = metadata.network();
        let mut params = BTreeMap::new();
        for (i, layer) in network.layers.iter().enumerate().filter(|(_, l)| l.op.has_weights()) {
            params.insert(layer.name.clone(), file.layer(&network, i)?);
        }
        file.finish()?;
        Ok(Self { metadata, network, params })
    }

    /// Reads a file of Open Image Denoise (TZA), whose name, less its extension, says what it is
    /// for: `rt_hdr_alb_nrm`, for example.
    ///
    /// # Errors
    /// As [`tza::to_safetensors`], and as [`from_bytes`](Self::from_bytes).
    pub fn from_tza(bytes: &[u8], name: &str) -> Result<Self> {
        Self::from_bytes(&tza::to_safetensors(bytes, name)?)
    }

    /// The built-in weights of a tier.
    ///
    /// # Errors
    /// If the crate was built without the feature of that tier: `fast`, `balanced` or `high`.
    pub fn builtin(quality: Quality) -> Result<Self> {
        let bytes: Option<&[u8]> = match quality {
            #[cfg(feature = "fast")]
            Quality::Fast => Some(include_bytes!("../../weights/fast.safetensors")),
            #[cfg(feature = "balanced")]
            Quality::Balanced => Some(include_bytes!("../../weights/balanced.safetensors")),
            #[cfg(feature = "high")]
            Quality::High => Some(include_bytes!("../../weights/high.safetensors")),
            #[allow(unreachable_patterns, reason = "with all features, every tier is above")]
            _ => None,
        };
        Self::from_bytes(bytes.ok_or_else(|| {
            let name = quality.name();
            Error::weights(format!(
                "the `{name}` weights are not built in; enable the crate's feature `{name}`"
            ))
        })?)
    }

    /// What the file says of itself.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The layers.
    #[must_use]
    #[doc(hidden)]
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Multiply-accumulates of the whole network per pixel of the image.
    #[must_use]
    pub fn macs_per_pixel(&self) -> f64 {
        macs_per_pixel(&self.network)
    }

    /// The weights of a layer; empty for a layer without.
    #[must_use]
    #[doc(hidden)]
    pub fn params(&self, layer: &str) -> Params {
        self.params.get(layer).cloned().unwrap_or_default()
    }

    /// The network for fewer inputs: the channels of absent images are cut out of every layer
    /// that reads the network's input, so that they cost nothing. The result is the same as
    /// feeding zeros.
    ///
    /// # Errors
    /// If `inputs` has an image that the network was not trained with, or lacks one that a network
    /// of this topology needs.
    ///
    /// # Panics
    /// Never: every layer that needs weights has them since the file was read.
    #[doc(hidden)]
    pub fn for_inputs(&self, inputs: Inputs) -> Result<Self> {
        let trained = self.metadata.inputs;
        if inputs.intersection(trained) != inputs {
            return Err(Error::weights(format!(
                "`{}` was trained with {trained}, but {inputs} was given; leave the others out",
                self.metadata.name
            )));
        }
        if inputs != trained && self.metadata.topology != Topology::Unet {
            let file = tza::for_inputs(&self.metadata, inputs)
                .map_or_else(String::new, |stem| format!(", such as {stem}.tza"));
            return Err(Error::weights(format!(
                "`{}` needs {trained}, but {inputs} was given; take weights that need no more{file}",
                self.metadata.name
            )));
        }
        let mut sliced = self.clone();
        sliced.metadata.inputs = inputs;
        sliced.network = sliced.metadata.network();
        let kept = kept_channels(&self.network, inputs.channels_of(trained));
        for layer in self.network.layers.iter().filter(|layer| layer.op.has_weights()) {
            let all = self.network.shapes[layer.inputs[0]].channels;
            let params = sliced.params.get_mut(&layer.name).expect("every such layer has weights");
            params.weight = slice(layer.op, params, &kept[layer.inputs[0]], all);
        }
        Ok(sliced)
    }
}

/// For every tensor, which of its channels remain when only `input` of the input's do.
fn kept_channels(network: &Network, input: Vec<usize>) -> Vec<Vec<usize>> {
    let mut kept = vec![input];
    for (i, layer) in network.layers.iter().enumerate() {
        let all = (0..network.shapes[i + 1].channels).collect();
        kept.push(if layer.op.has_weights() { all } else { joined(network, layer, &kept) });
    }
    kept
}

/// The channels that remain of a layer that only passes its inputs' on, one input behind the other.
fn joined(network: &Network, layer: &Layer, kept: &[Vec<usize>]) -> Vec<usize> {
    let mut first = 0;
    let of_input = |&input: &usize| {
        let offset = first;
        first += network.shapes[input].channels;
        kept[input].iter().map(|c| c + offset).collect::<Vec<_>>()
    };
    layer.inputs.iter().flat_map(of_input).collect()
}

/// A layer's weight without the input channels that are not in `kept`.
fn slice(op: Op, params: &Params, kept: &[usize], all: usize) -> Vec<f32> {
    let outputs = params.bias.len();
    let per_input = params.weight.len() / all;
    if matches!(op.facts().weights, Some(Axes::InputOutput(_))) {
        let of = |&c: &usize| &params.weight[c * per_input..][..per_input];
        return kept.iter().flat_map(of).copied().collect();
    }
    let taps = per_input / outputs;
    let of = |filter: &[f32]| -> Vec<f32> {
        kept.iter().flat_map(|&c| filter[c * taps..][..taps].to_vec()).collect()
    };
    params.weight.chunks_exact(all * taps).flat_map(of).collect()
}
