//! The purpose of an Open Image Denoise network, known only from the file's name.

use crate::error::{Error, Result};
use crate::model::MainImage::{self, Albedo, Color, Normal};
use crate::model::TransferFunction::{self, Log, Pu, Signed, Srgb};
use crate::model::{Inputs, Metadata};

/// The purpose of the files with one name, for all network sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TzaKind {
    /// The file's name without size and extension, such as `rt_hdr_alb_nrm`.
    pub stem: &'static str,
    /// The images the network reads.
    pub inputs: Inputs,
    /// What the first image contains.
    pub main: MainImage,
    /// How the first image is encoded.
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

/// All kinds of weights files.
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
    /// The kind of a file by its name without extension.
    ///
    /// # Errors
    /// Fails if Open Image Denoise has no file of this name.
    pub fn of(name: &str) -> Result<Self> {
        let stem = name.strip_suffix("_small").or_else(|| name.strip_suffix("_large"));
        let stem = stem.unwrap_or(name);
        KINDS.into_iter().find(|kind| kind.stem == stem).ok_or_else(|| {
            Error::weights(format!(
                "`{name}` is not the name of any Open Image Denoise weights, and only its name tells \
                 what a TZA file is for; restore the file's original name, such as \
                 rt_hdr_alb_nrm.tza"
            ))
        })
    }
}

/// The name, without size, of the weights that serve the purpose of `metadata`, read as many of
/// `inputs` as possible and read no other image.
#[must_use]
pub fn for_inputs(metadata: &Metadata, inputs: Inputs) -> Option<&'static str> {
    let fits = |kind: &TzaKind| {
        let same = (kind.main, kind.transfer) == (metadata.main, metadata.transfer_function);
        same && kind.inputs.intersection(inputs) == kind.inputs
    };
    // `max_by_key` returns the last of equals: in reverse, the kinds for noisy albedo and normal.
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
