//! What a network of Open Image Denoise is for: a file says it by its name alone.

use crate::error::{Error, Result};
use crate::model::Inputs;

/// What the files of one name are for, whatever their size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// The file's name without size and extension, such as `rt_hdr_alb_nrm`.
    pub stem: &'static str,
    /// What the network reads.
    pub inputs: Inputs,
    /// What the main image is: `color`, `albedo` or `normal`.
    pub main: &'static str,
    /// How it is encoded, as in a weights file.
    pub transfer: &'static str,
}

const ALBEDO: Inputs = Inputs { albedo: true, normal: false };
const NONE: Inputs = Inputs { albedo: false, normal: false };

const fn kind(
    stem: &'static str,
    inputs: Inputs,
    main: &'static str,
    transfer: &'static str,
) -> Kind {
    Kind { stem, inputs, main, transfer }
}

/// All there are.
pub const KINDS: [Kind; 12] = [
    kind("rt_hdr", NONE, "color", "pu"),
    kind("rt_hdr_alb", ALBEDO, "color", "pu"),
    kind("rt_hdr_alb_nrm", Inputs::ALL, "color", "pu"),
    kind("rt_hdr_calb_cnrm", Inputs::ALL, "color", "pu"),
    kind("rt_ldr", NONE, "color", "srgb"),
    kind("rt_ldr_alb", ALBEDO, "color", "srgb"),
    kind("rt_ldr_alb_nrm", Inputs::ALL, "color", "srgb"),
    kind("rt_ldr_calb_cnrm", Inputs::ALL, "color", "srgb"),
    kind("rt_alb", NONE, "albedo", "srgb"),
    kind("rt_nrm", NONE, "normal", "signed"),
    kind("rtlightmap_hdr", NONE, "color", "log"),
    kind("rtlightmap_dir", NONE, "color", "signed"),
];

impl Kind {
    /// The kind of a file with this name, less its extension.
    ///
    /// # Errors
    /// If Open Image Denoise has no file of this name.
    pub fn of(name: &str) -> Result<Self> {
        let stem = name.strip_suffix("_small").or_else(|| name.strip_suffix("_large"));
        let stem = stem.unwrap_or(name);
        KINDS.into_iter().find(|kind| kind.stem == stem).ok_or_else(|| {
            Error::Weights(format!(
                "`{name}` is no name of Open Image Denoise's weights, and a TZA file says only by \
                 its name what it is for; give the file the name that it came with, such as \
                 rt_hdr_alb_nrm.tza"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_what_the_network_reads() {
        let kind = Kind::of("rt_ldr_alb_small").unwrap();
        assert_eq!((kind.stem, kind.inputs, kind.transfer), ("rt_ldr_alb", ALBEDO, "srgb"));
        for name in ["", "rt_hdr_nrm", "rt_hdr_alb_nrm_tiny", "_small", "model"] {
            assert!(Kind::of(name).unwrap_err().to_string().contains(&format!("`{name}`")));
        }
    }
}
