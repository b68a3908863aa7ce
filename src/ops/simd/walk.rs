//! How a kernel walks over a tensor: in steps of one kernel row of four input channels.

/// A loop over kernel rows and input quads. Positions are WGSL expressions in `x`, `y` (the
/// invocation's first output pixel), `row` and the names that [`super::text`] declares.
pub(super) struct Walk {
    /// The tensor's name.
    pub(super) tensor: &'static str,
    /// The name of its weights.
    pub(super) weights: &'static str,
    /// Kernel rows.
    pub(super) rows: usize,
    /// Taps of a step, each with weights of its own.
    pub(super) taps: usize,
    /// Texels of a row that a step reads, starting at column `x`.
    pub(super) texels: fn(pixels: usize) -> usize,
    /// Column of the first texel.
    pub(super) x: &'static str,
    /// Row of the texels.
    pub(super) y: &'static str,
    /// First row of weights.
    pub(super) first_step: &'static str,
    /// The `(tap, texel)` pairs that an output pixel sums.
    pub(super) terms: fn(pixel: usize) -> Vec<(usize, usize)>,
}

/// The 3×3 neighborhood of each pixel.
pub(super) const ROWS: Walk = Walk {
    tensor: "input",
    weights: "weights",
    rows: 3,
    taps: 3,
    texels: |pixels| pixels + 2,
    x: "x - 1",
    y: "y + row - 1",
    first_step: "0",
    terms: |pixel| (0..3).map(|column| (column, pixel + column)).collect(),
};

/// The same over the skip of a decoder level.
pub(super) const SKIP: Walk = Walk { tensor: "skip", ..ROWS };

/// The 2×2 low-resolution pixels under the 3×3 neighborhood of each pixel. The parity of the
/// pixel's coordinates selects pixels and weights. `x` is even.
pub(super) const LOW: Walk = Walk {
    tensor: "low",
    weights: "weights",
    rows: 2,
    taps: 4,
    texels: |pixels| pixels / 2 + 2,
    x: "x / 2 - 1",
    y: "(y + 1) / 2 + row - 1",
    first_step: "3 * i32(textureNumLayers(skip)) + (y & 1) * 2 * i32(textureNumLayers(low))",
    terms: |pixel| (0..2).map(|c| (pixel % 2 * 2 + c, pixel.div_ceil(2) + c)).collect(),
};

/// Each pixel alone.
pub(super) const POINT: Walk = Walk {
    tensor: "input",
    weights: "weights",
    rows: 1,
    taps: 1,
    texels: |pixels| pixels,
    x: "x",
    y: "y",
    first_step: "0",
    terms: |pixel| vec![(0, pixel)],
};
