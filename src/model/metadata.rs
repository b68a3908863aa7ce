//! What a weights file says of itself, in the `__metadata__` of its safetensors header.

use std::collections::HashMap;

use super::shown::{is_printable, shown};
use super::{Inputs, Network};
use crate::error::{Error, Result};

/// The metadata of format version 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// A short name, such as `balanced`: 1 to 64 characters that can be printed.
    pub name: String,
    /// Channels of each encoder level and of the bottom.
    pub widths: Vec<usize>,
    /// What the network was trained with.
    pub inputs: Inputs,
    /// Added to the variance of every batch norm.
    pub norm_eps: Option<f64>,
    /// Data, loss, steps, licence: free text.
    pub provenance: String,
}

const MAX_LEVELS: usize = 8;
const MAX_WIDTH: usize = 1024;
const MAX_NAME: usize = 64;

impl Metadata {
    /// Reads the key-value pairs of the header.
    ///
    /// # Errors
    /// If a key is missing or has a value that this version does not know.
    pub fn parse(pairs: &HashMap<String, String>) -> Result<Self> {
        expect(pairs, "format", "wgdenoise")?;
        expect(pairs, "format_version", "1")?;
        expect(pairs, "topology", "unet")?;
        expect(pairs, "transfer_function", "pu")?;
        Ok(Self {
            name: name(get(pairs, "name")?)?,
            widths: widths(get(pairs, "widths")?)?,
            inputs: Inputs::parse(get(pairs, "inputs")?)?,
            norm_eps: pairs.get("norm_eps").map(|text| norm_eps(text)).transpose()?,
            provenance: get(pairs, "provenance")?.to_string(),
        })
    }

    /// The network that the metadata describes.
    #[must_use]
    pub fn network(&self) -> Network {
        Network::unet(self.inputs.channels(), &self.widths)
    }
}

fn get<'a>(pairs: &'a HashMap<String, String>, key: &str) -> Result<&'a str> {
    pairs.get(key).map(String::as_str).ok_or_else(|| {
        Error::Weights(format!(
            "metadata `{key}` is missing; export the file as weights-format.md says"
        ))
    })
}

fn expect(pairs: &HashMap<String, String>, key: &str, expected: &str) -> Result<()> {
    let found = get(pairs, key)?;
    if found == expected {
        return Ok(());
    }
    Err(Error::Weights(format!(
        "metadata `{key}` is `{}`, but this version reads only `{expected}`",
        shown(found)
    )))
}

/// The name stands in lines that the program prints.
fn name(text: &str) -> Result<String> {
    if (1..=MAX_NAME).contains(&text.chars().count()) && text.chars().all(is_printable) {
        return Ok(text.to_string());
    }
    Err(Error::Weights(format!(
        "metadata `name` is `{}`, expected 1 to {MAX_NAME} characters that can be printed",
        shown(text)
    )))
}

fn widths(text: &str) -> Result<Vec<usize>> {
    let parsed: Option<Vec<usize>> = text.split(',').map(|w| w.trim().parse().ok()).collect();
    let valid = |widths: &Vec<usize>| {
        (2..=MAX_LEVELS).contains(&widths.len())
            && widths.iter().all(|w| (1..=MAX_WIDTH).contains(w))
    };
    parsed.filter(valid).ok_or_else(|| {
        Error::Weights(format!(
            "metadata `widths` is `{}`, expected 2 to {MAX_LEVELS} numbers from 1 to \
             {MAX_WIDTH} with commas between them",
            shown(text)
        ))
    })
}

fn norm_eps(text: &str) -> Result<f64> {
    let valid = |eps: &f64| *eps > 0.0 && *eps < 1.0;
    text.parse().ok().filter(valid).ok_or_else(|| {
        Error::Weights(format!(
            "metadata `norm_eps` is `{}`, expected a number between 0 and 1",
            shown(text)
        ))
    })
}
