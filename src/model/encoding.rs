//! How images become a network's input.

/// What a network was trained to read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Encoding {
    /// Whether the input is 0 right of and below the image, where its sides are no multiples of
    /// the alignment. If not, the edge repeats.
    pub zero_padding: bool,
}
