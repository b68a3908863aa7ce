//! How images become a network's input, and its output an image.

/// What a network was trained to read and to make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Encoding {
    /// The curve between colour and the network's numbers.
    pub transfer_function: TransferFunction,
    /// Whether the input is 0 right of and below the image, where its sides are no multiples of
    /// the alignment. If not, the edge repeats.
    pub zero_padding: bool,
    /// Whether light is encoded however bright it is. If not, it counts as 65504 at most, times the
    /// exposure.
    pub unbounded: bool,
}

impl Encoding {
    /// What is brighter, times the exposure, counts as this.
    #[must_use]
    pub fn brightest(self) -> f32 {
        if self.unbounded { MOST } else { LARGEST }
    }

    /// The overrides of the shaders that encode or decode.
    #[must_use]
    pub fn constants(self) -> [(&'static str, f64); 2] {
        let curve = f64::from(self.transfer_function as u8);
        [("transfer_function", curve), ("brightest", f64::from(self.brightest()))]
    }

    /// The encoding in which equal steps look about equally large: the same, but
    /// [`TransferFunction::Pu`] for light, of whose dark parts a logarithm of `y + 1` makes little.
    #[must_use]
    pub fn perceptual(self) -> Self {
        match self.transfer_function {
            TransferFunction::Log => Self { transfer_function: TransferFunction::Pu, ..self },
            _ => self,
        }
    }
}

/// What the bounded curves for light make 1.
const LARGEST: f32 = 65504.0;

/// The most that counts of any light, as in the repair and in the exposure.
const MOST: f32 = 1e30;

/// A curve from colour, times the exposure, to `[0, 1]`, or for light above 65504 beyond.
/// `weights-format.md` has the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TransferFunction {
    /// Perceptually uniform, for scene-referred light.
    #[default]
    Pu,
    /// Logarithmic, for scene-referred light in lightmaps.
    Log,
    /// That of sRGB, for display-referred colour and albedo in `[0, 1]`.
    Srgb,
    /// `0.5 v + 0.5`, for normals and directions in `[−1, 1]`.
    Signed,
}

impl TransferFunction {
    /// All of them, in the order in which shaders count them.
    pub const ALL: [Self; 4] = [Self::Pu, Self::Log, Self::Srgb, Self::Signed];

    /// As in a weights file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pu => "pu",
            Self::Log => "log",
            Self::Srgb => "srgb",
            Self::Signed => "signed",
        }
    }

    /// Whether the values are of any size, so that the exposure is measured unless it is given; for
    /// the others it is 1.
    #[must_use]
    pub fn is_hdr(self) -> bool {
        matches!(self, Self::Pu | Self::Log)
    }
}
