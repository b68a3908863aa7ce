//! A weights file, checked and folded. `weights-format.md` is normative.

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

/// Picks one of the built-in weights, trading time for error. `weights/README.md` lists their
/// widths and errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Shortest time: 8 base channels, 12 kMAC per pixel.
    Fast,
    /// 16 base channels, 41 kMAC per pixel.
    #[default]
    Balanced,
    /// Least error: 24 base channels, 86 kMAC per pixel.
    High,
}

impl Quality {
    /// All qualities, by rising cost.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Balanced, Self::High];

    /// The qualities built in through the crate's features, by rising cost.
    #[must_use]
    pub fn built_in() -> Vec<Self> {
        let has = |quality: &Self| match quality {
            Self::Fast => cfg!(feature = "fast"),
            Self::Balanced => cfg!(feature = "balanced"),
            Self::High => cfg!(feature = "high"),
        };
        Self::ALL.into_iter().filter(has).collect()
    }

    /// Its name on the command line: `fast`, `balanced` or `high`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::High => "high",
        }
    }

    /// The next cheaper quality.
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
    /// Fails if the file is not safetensors, its metadata does not follow the format, a tensor is
    /// missing, unknown, or of the wrong shape or type, or a value is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut file = WeightsFile::open(bytes)?;
        let metadata = file.metadata.clone();
        let network = network(&metadata, file.demodulates());
        let mut params = BTreeMap::new();
        for (i, layer) in network.layers.iter().enumerate().filter(|(_, l)| l.op.has_weights()) {
            params.insert(layer.name.clone(), file.layer(&network, i)?);
        }
        file.finish()?;
        Ok(Self { metadata, network, params })
    }

    /// Reads a weights file of Open Image Denoise (TZA). `name` is the file's name without
    /// extension, such as `rt_hdr_alb_nrm`; it alone determines what the weights are for.
    ///
    /// # Errors
    /// Fails like [`tza::to_safetensors`] and [`from_bytes`](Self::from_bytes).
    pub fn from_tza(bytes: &[u8], name: &str) -> Result<Self> {
        Self::from_bytes(&tza::to_safetensors(bytes, name)?)
    }

    /// The built-in weights of a quality.
    ///
    /// # Errors
    /// Fails if the crate was built without that quality's feature: `fast`, `balanced` or `high`.
    pub fn builtin(quality: Quality) -> Result<Self> {
        let bytes: Option<&[u8]> = match quality {
            #[cfg(feature = "fast")]
            Quality::Fast => Some(include_bytes!("../../weights/fast.safetensors")),
            #[cfg(feature = "balanced")]
            Quality::Balanced => Some(include_bytes!("../../weights/balanced.safetensors")),
            #[cfg(feature = "high")]
            Quality::High => Some(include_bytes!("../../weights/high.safetensors")),
            #[cfg(not(all(feature = "fast", feature = "balanced", feature = "high")))]
            _ => None,
        };
        Self::from_bytes(bytes.ok_or_else(|| {
            let name = quality.name();
            Error::weights(format!(
                "the `{name}` weights are not built in; enable the crate's feature `{name}`"
            ))
        })?)
    }

    /// The file's metadata.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The network's layers.
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

    /// [`macs_per_pixel`](Self::macs_per_pixel) if only these images are given: the channels of the
    /// others are cut out.
    ///
    /// # Errors
    /// Fails if the network was not trained with one of these images or cannot do without another.
    pub fn macs_per_pixel_for(&self, inputs: Inputs) -> Result<f64> {
        Ok(self.for_inputs(inputs)?.macs_per_pixel())
    }

    /// The weights of a layer; empty if it has none.
    #[must_use]
    #[doc(hidden)]
    pub fn params(&self, layer: &str) -> Params {
        self.params.get(layer).cloned().unwrap_or_default()
    }

    /// The network for fewer inputs. The channels of absent images are cut out of every layer that
    /// reads the network's input, so they cost nothing. The result equals feeding zeros.
    ///
    /// # Errors
    /// Fails if the network was not trained with an image of `inputs`, or if its topology needs an
    /// image that `inputs` lacks.
    ///
    /// # Panics
    /// Never panics: reading the file checked that every layer has its weights.
    #[doc(hidden)]
    pub fn for_inputs(&self, inputs: Inputs) -> Result<Self> {
        let trained = self.metadata.inputs;
        if inputs.intersection(trained) != inputs {
            return Err(Error::weights(format!(
                "`{}` was trained with {trained}, but {inputs} was given; leave the others out",
                self.metadata.name
            )));
        }
        if inputs != trained && matches!(self.metadata.topology, Topology::Oidn(_)) {
            let file = tza::for_inputs(&self.metadata, inputs)
                .map_or_else(String::new, |stem| format!(", such as {stem}.tza"));
            return Err(Error::weights(format!(
                "`{}` needs {trained}, but {inputs} was given; use weights that need no more{file}",
                self.metadata.name
            )));
        }
        let mut sliced = self.clone();
        sliced.metadata.inputs = inputs;
        sliced.network = network(&sliced.metadata, self.network.demodulates());
        let kept = kept_channels(&self.network, inputs.channels_of(trained));
        for layer in self.network.layers.iter().filter(|layer| layer.op.has_weights()) {
            let all = self.network.shapes[layer.inputs[0]].channels;
            let params = sliced.params.get_mut(&layer.name).expect("every such layer has weights");
            params.weight = slice(layer.op, params, &kept[layer.inputs[0]], all);
        }
        Ok(sliced)
    }
}

/// The network that the metadata describes, with or without the demodulation logit.
fn network(metadata: &Metadata, demodulates: bool) -> Network {
    let network = metadata.network();
    if demodulates { network.demodulating() } else { network }
}

/// For each tensor, the channels that remain if only channels `input` of the network's input do.
fn kept_channels(network: &Network, input: Vec<usize>) -> Vec<Vec<usize>> {
    let mut kept = vec![input];
    for (i, layer) in network.layers.iter().enumerate() {
        let all = (0..network.shapes[i + 1].channels).collect();
        kept.push(if layer.op.has_weights() { all } else { joined(network, layer, &kept) });
    }
    kept
}

/// The remaining channels of a layer without weights, which passes on its inputs' channels in
/// order.
fn joined(network: &Network, layer: &Layer, kept: &[Vec<usize>]) -> Vec<usize> {
    let mut first = 0;
    let of_input = |&input: &usize| {
        let offset = first;
        first += network.shapes[input].channels;
        kept[input].iter().map(|c| c + offset).collect::<Vec<_>>()
    };
    layer.inputs.iter().flat_map(of_input).collect()
}

/// A layer's weight reduced to the input channels in `kept`.
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
