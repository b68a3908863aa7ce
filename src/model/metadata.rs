//! The metadata of a weights file: the `__metadata__` of its safetensors header.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use super::encoding::{Encoding, TransferFunction};
use super::inputs::Inputs;
use super::oidn::OidnSize;
use super::shown::{is_printable, shown};
use super::topology::Network;
use crate::error::{Error, Result};

/// The metadata of format version 1.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Metadata {
    /// A short name such as `balanced`: 1 to 64 printable characters.
    pub name: String,
    /// The kind of network.
    pub topology: Topology,
    /// Channel counts: for [`Topology::Oidn`], the output channels of every convolution but the
    /// last; for the others, the channels of each encoder level and of the bottom.
    pub widths: Vec<usize>,
    /// The images the network was trained with.
    pub inputs: Inputs,
    /// What the first image contains.
    pub main: MainImage,
    /// How the first image is encoded.
    pub transfer_function: TransferFunction,
    /// The epsilon added to the variance of every batch norm.
    pub norm_eps: Option<f64>,
    /// Data, loss, steps and license, as free text.
    pub provenance: String,
}

/// The image a network denoises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MainImage {
    /// Color.
    #[default]
    Color,
    /// Albedo, passed in place of color.
    Albedo,
    /// Normal, passed in place of color.
    Normal,
}

impl MainImage {
    /// Its name in a weights file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
        }
    }
}

/// The kinds of network that a file can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Topology {
    /// The thesis network: two convolutions and a max-pool per level, then transposed convolutions
    /// and skips. Its output is color.
    Unet,
    /// The thesis network with another output: the weights that average a pyramid of the noisy
    /// color.
    KernelPyramid,
    /// A network of Intel Open Image Denoise, with nearest upsampling.
    Oidn(OidnSize),
}

impl Topology {
    /// Its name in a weights file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unet => "unet",
            Self::KernelPyramid => "kernel-pyramid",
            Self::Oidn(OidnSize::Base) => "oidn",
            Self::Oidn(OidnSize::Large) => "oidn-large",
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let oidn = [OidnSize::Base, OidnSize::Large].map(Self::Oidn);
        let all = [Self::Unet, Self::KernelPyramid].into_iter().chain(oidn);
        all.into_iter().find(|topology| topology.name() == text)
    }

    /// The allowed numbers of widths.
    fn widths(self) -> RangeInclusive<usize> {
        match self {
            Self::Unet => 2..=MAX_LEVELS,
            Self::KernelPyramid => 2..=MAX_PYRAMID_LEVELS,
            Self::Oidn(size) => size.convolutions() - 1..=size.convolutions() - 1,
        }
    }
}

const MAX_LEVELS: usize = 8;
/// Confidences multiply from level to level; with more levels their products could leave the range
/// of 32-bit floats.
const MAX_PYRAMID_LEVELS: usize = 5;
pub(super) const MAX_WIDTH: usize = 1024;
const MAX_NAME: usize = 64;

impl Metadata {
    /// Reads the key–value pairs of the header.
    ///
    /// # Errors
    /// Fails if a key is missing or has a value that this version does not know.
    #[doc(hidden)]
    pub fn parse(pairs: &HashMap<String, String>) -> Result<Self> {
        expect(pairs, "format", "wgdenoise")?;
        expect(pairs, "format_version", "1")?;
        let topology = topology(pairs)?;
        Ok(Self {
            name: name(get(pairs, "name")?)?,
            topology,
            widths: widths(get(pairs, "widths")?, topology)?,
            inputs: Inputs::parse(get(pairs, "inputs")?)?,
            main: pairs.get("main").map_or(Ok(MainImage::Color), |text| main(text))?,
            transfer_function: transfer_function(get(pairs, "transfer_function")?)?,
            norm_eps: pairs.get("norm_eps").map(|text| norm_eps(text)).transpose()?,
            provenance: get(pairs, "provenance")?.to_string(),
        })
    }

    /// How images become the network's input.
    #[must_use]
    #[doc(hidden)]
    pub fn encoding(&self) -> Encoding {
        let oidn = matches!(self.topology, Topology::Oidn(_));
        let transfer_function = self.transfer_function;
        let gathered = self.topology == Topology::KernelPyramid;
        Encoding { transfer_function, zero_padding: oidn, unbounded: oidn, gathered }
    }

    /// The network described by the metadata.
    #[must_use]
    #[doc(hidden)]
    pub fn network(&self) -> Network {
        let channels = self.inputs.channels();
        match self.topology {
            Topology::Unet => Network::unet(channels, &self.widths),
            Topology::KernelPyramid => Network::kernel_pyramid(channels, &self.widths),
            Topology::Oidn(size) => Network::oidn(channels, size, &self.widths),
        }
    }
}

fn get<'a>(pairs: &'a HashMap<String, String>, key: &str) -> Result<&'a str> {
    pairs.get(key).map(String::as_str).ok_or_else(|| {
        Error::weights(format!(
            "metadata `{key}` is missing; export the file as described in weights-format.md"
        ))
    })
}

fn expect(pairs: &HashMap<String, String>, key: &str, expected: &str) -> Result<()> {
    let found = get(pairs, key)?;
    if found == expected {
        return Ok(());
    }
    Err(Error::weights(format!(
        "metadata `{key}` is `{}`, but this version reads only `{expected}`",
        shown(found)
    )))
}

/// Checks the name, which is restricted because programs print it.
fn name(text: &str) -> Result<String> {
    if (1..=MAX_NAME).contains(&text.chars().count()) && text.chars().all(is_printable) {
        return Ok(text.to_string());
    }
    Err(Error::weights(format!(
        "metadata `name` is `{}`, expected 1 to {MAX_NAME} printable characters",
        shown(text)
    )))
}

fn topology(pairs: &HashMap<String, String>) -> Result<Topology> {
    let text = get(pairs, "topology")?;
    Topology::parse(text).ok_or_else(|| {
        Error::weights(format!(
            "metadata `topology` is `{}`, but this version reads only `unet`, \
             `kernel-pyramid`, `oidn` and `oidn-large`",
            shown(text)
        ))
    })
}

fn main(text: &str) -> Result<MainImage> {
    let all = [MainImage::Color, MainImage::Albedo, MainImage::Normal];
    all.into_iter().find(|main| main.name() == text).ok_or_else(|| {
        Error::weights(format!(
            "metadata `main` is `{}`, expected `color`, `albedo` or `normal`",
            shown(text)
        ))
    })
}

fn transfer_function(text: &str) -> Result<TransferFunction> {
    TransferFunction::ALL.into_iter().find(|curve| curve.name() == text).ok_or_else(|| {
        Error::weights(format!(
            "metadata `transfer_function` is `{}`, but this version reads only `pu`, `log`, \
             `srgb` and `signed`",
            shown(text)
        ))
    })
}

fn widths(text: &str, topology: Topology) -> Result<Vec<usize>> {
    let parsed: Option<Vec<usize>> = text.split(',').map(|w| w.trim().parse().ok()).collect();
    let valid = |widths: &Vec<usize>| {
        topology.widths().contains(&widths.len())
            && widths.iter().all(|w| (1..=MAX_WIDTH).contains(w))
    };
    parsed.filter(valid).ok_or_else(|| {
        let (least, most) = topology.widths().into_inner();
        let count = if least == most { most.to_string() } else { format!("{least} to {most}") };
        Error::weights(format!(
            "metadata `widths` is `{}`, expected {count} numbers from 1 to {MAX_WIDTH} with \
             commas between them",
            shown(text)
        ))
    })
}

fn norm_eps(text: &str) -> Result<f64> {
    let valid = |eps: &f64| *eps > 0.0 && *eps < 1.0;
    text.parse().ok().filter(valid).ok_or_else(|| {
        Error::weights(format!(
            "metadata `norm_eps` is `{}`, expected a number between 0 and 1",
            shown(text)
        ))
    })
}
