//! How images become a network's input, and how its output becomes an image.

/// The encoding of a network's input and output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Encoding {
    /// The curve from color to the network's values.
    pub transfer_function: TransferFunction,
    /// Whether the input is 0 to the right of and below the image, up to the next multiple of the
    /// alignment. Otherwise the edge pixels repeat.
    pub zero_padding: bool,
    /// Whether light of any brightness is encoded. Otherwise it is clamped to 65504 after exposure.
    pub unbounded: bool,
    /// Whether the network predicts weights that average the noisy color, so that it can reject
    /// outliers itself.
    pub gathered: bool,
}

impl Encoding {
    /// The brightest exposed value; larger ones are clamped to it.
    #[must_use]
    pub fn brightest(self) -> f32 {
        if self.unbounded { MOST } else { LARGEST }
    }

    /// How many times brighter than its surroundings a pixel may be; brighter ones are darkened.
    #[must_use]
    pub fn outlier(self) -> f64 {
        if self.gathered { 256.0 } else { 16.0 }
    }

    /// Override constants for the shaders that repair, encode or decode.
    #[must_use]
    pub fn constants(self) -> [(&'static str, f64); 3] {
        let curve = f64::from(self.transfer_function as u8);
        let brightest = f64::from(self.brightest());
        [("transfer_function", curve), ("brightest", brightest), ("outlier", self.outlier())]
    }
}

/// The value that the bounded curves for light map to 1.
const LARGEST: f32 = 65504.0;

/// Brighter light is clamped to this, as in the repair and the exposure.
const MOST: f32 = 1e30;

/// A curve from exposed color to `[0, 1]`, or beyond 1 for light above 65504. `weights-format.md`
/// has the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TransferFunction {
    /// Perceptually uniform, for scene-referred light.
    #[default]
    Pu,
    /// Logarithmic, for scene-referred light in lightmaps.
    Log,
    /// The sRGB curve, for display-referred color and albedo in `[0, 1]`.
    Srgb,
    /// `0.5 v + 0.5`, for normals and directions in `[−1, 1]`.
    Signed,
}

impl TransferFunction {
    /// All curves, in the order of the shaders' numbering.
    pub const ALL: [Self; 4] = [Self::Pu, Self::Log, Self::Srgb, Self::Signed];

    /// Its name in a weights file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pu => "pu",
            Self::Log => "log",
            Self::Srgb => "srgb",
            Self::Signed => "signed",
        }
    }

    /// Whether values are unbounded, so that exposure is measured unless given. For the other
    /// curves, the input scale is 1.
    #[must_use]
    pub fn is_hdr(self) -> bool {
        matches!(self, Self::Pu | Self::Log)
    }
}
