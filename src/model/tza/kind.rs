//! What a network of Open Image Denoise is for: a file says it by its name alone.

use crate::error::{Error, Result};
use crate::model::MainImage::{self, Albedo, Color, Normal};
use crate::model::TransferFunction::{self, Log, Pu, Signed, Srgb};
use crate::model::{Inputs, Metadata};

/// What the files of one name are for, whatever their size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TzaKind {
    /// The file's name without size and extension, such as `rt_hdr_alb_nrm`.
    pub stem: &'static str,
    /// What the network reads.
    pub inputs: Inputs,
    /// What the first image is.
    pub main: MainImage,
    /// How it is encoded.
    pub transfer: TransferFunction,
}

const ALBEDO: Inputs = Inputs { albedo: true, normal: false };
const NONE: Inputs = Inputs { albedo: false, normal: false };

const fn kind(
    stem: &'static str,
    inputs: Inputs,
    main: MainImage,
    transfer: TransferFunction,
) -> TzaKind {
    TzaKind { stem, inputs, main, transfer }
}

/// All there are.
pub const KINDS: [TzaKind; 12] = [
    kind("rt_hdr", NONE, Color, Pu),
    kind("rt_hdr_alb", ALBEDO, Color, Pu),
    kind("rt_hdr_alb_nrm", Inputs::ALL, Color, Pu),
    kind("rt_hdr_calb_cnrm", Inputs::ALL, Color, Pu),
    kind("rt_ldr", NONE, Color, Srgb),
    kind("rt_ldr_alb", ALBEDO, Color, Srgb),
    kind("rt_ldr_alb_nrm", Inputs::ALL, Color, Srgb),
    kind("rt_ldr_calb_cnrm", Inputs::ALL, Color, Srgb),
    kind("rt_alb", NONE, Albedo, Srgb),
    kind("rt_nrm", NONE, Normal, Signed),
    kind("rtlightmap_hdr", NONE, Color, Log),
    kind("rtlightmap_dir", NONE, Color, Signed),
];

impl TzaKind {
    /// The kind of a file with this name, less its extension.
    ///
    /// # Errors
    /// If Open Image Denoise has no file of this name.
    pub fn of(name: &str) -> Result<Self> {
        let stem = name.strip_suffix("_small").or_else(|| name.strip_suffix("_large"));
        let stem = stem.unwrap_or(name);
        KINDS.into_iter().find(|kind| kind.stem == stem).ok_or_else(|| {
            Error::weights(format!(
                "`{name}` is no name of Open Image Denoise's weights, and a TZA file says only by \
                 its name what it is for; give the file the name that it came with, such as \
                 rt_hdr_alb_nrm.tza"
            ))
        })
    }
}

/// The name, less the size, of weights that do what those of `metadata` do and read the most of
/// `inputs`, and nothing else.
#[must_use]
pub fn for_inputs(metadata: &Metadata, inputs: Inputs) -> Option<&'static str> {
    let fits = |kind: &TzaKind| {
        let same = (kind.main, kind.transfer) == (metadata.main, metadata.transfer_function);
        same && kind.inputs.intersection(inputs) == kind.inputs
    };
    // Of equals, the last counts, and those for noisy albedo and normal stand first.
    let kinds = KINDS.into_iter().rev().filter(fits);
    kinds.max_by_key(|kind| kind.inputs.channels()).map(|kind| kind.stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_what_the_network_reads() {
        let kind = TzaKind::of("rt_ldr_alb_small").unwrap();
        assert_eq!((kind.stem, kind.inputs, kind.transfer), ("rt_ldr_alb", ALBEDO, Srgb));
        for name in ["", "rt_hdr_nrm", "rt_hdr_alb_nrm_tiny", "_small", "model"] {
            assert!(TzaKind::of(name).unwrap_err().to_string().contains(&format!("`{name}`")));
        }
    }
}
