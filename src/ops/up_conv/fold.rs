//! Folds two convolutions into one set of weights.

use crate::model::Params;

/// Weights of the folded operator.
pub(super) struct Folded {
    pub(super) outputs: usize,
    /// Weights of the skip: `[output][skip][9 taps]`.
    pub(super) skip: Vec<f32>,
    /// Weights of the low-resolution tensor: `[output][16 taps][low]`; see [`tap`].
    pub(super) low: Vec<f32>,
    /// `[above, inside, below][left, inside, right][output]`.
    pub(super) bias: Vec<f32>,
}

/// Index of a low-resolution tap: parity of the output's row and column, then row and column among
/// the 2×2 low-resolution pixels.
fn tap([y, x]: [usize; 2], [row, column]: [usize; 2]) -> usize {
    ((y * 2 + x) * 2 + row) * 2 + column
}

/// Along one axis, tap `k` of the 3×3 kernel at an output of this parity sees the upsampled pixel
/// whose parity is the first result, inside the low-resolution pixel given by the second.
fn seen(parity: usize, k: usize) -> [usize; 2] {
    let upsampled = parity + k + 1; // counted from two before the output's own even pixel
    [upsampled % 2, upsampled / 2 - parity.div_ceil(2)]
}

/// The parts of [`super::up_conv`]'s parameters.
struct Parts<'a> {
    up: &'a [f32],
    conv: &'a [f32],
    up_bias: &'a [f32],
    conv_bias: &'a [f32],
    skips: usize,
}

impl Parts<'_> {
    /// The 3×3 convolution's weight for an upsampled channel.
    fn conv(&self, output: usize, up: usize, ky: usize, kx: usize) -> f64 {
        let channels = self.skips + self.up_bias.len();
        f64::from(self.conv[((output * channels + self.skips + up) * 3 + ky) * 3 + kx])
    }
}

impl Folded {
    /// Splits and folds the parameters.
    pub(super) fn new(params: &Params, skips: usize, lows: usize, ups: usize) -> Self {
        let (up, conv) = params.weight.split_at(lows * ups * 4);
        let (up_bias, conv_bias) = params.bias.split_at(ups);
        let parts = Parts { up, conv, up_bias, conv_bias, skips };
        let outputs = conv_bias.len();
        let skip = conv.chunks_exact((skips + ups) * 9).flat_map(|f| &f[..skips * 9]).copied();
        Self { outputs, skip: skip.collect(), low: low(&parts, lows), bias: bias(&parts) }
    }
}

/// For each tap and both parities, adds the product with every low-resolution channel.
fn low(parts: &Parts<'_>, lows: usize) -> Vec<f32> {
    let ups = parts.up_bias.len();
    // [upsampled][2×2][low], so that the innermost loop walks contiguous memory.
    let at = |i: usize| parts.up[(i % lows * ups + i / lows / 4) * 4 + i / lows % 4];
    let by_up: Vec<f64> = (0..ups * 4 * lows).map(|i| f64::from(at(i))).collect();
    let ranges: Vec<_> = by_up.chunks_exact(lows).map(used).collect();
    let mut folded = Vec::new();
    for output in 0..parts.conv_bias.len() {
        let mut sums = vec![0.0; 16 * lows];
        for (i, parity) in (0..ups * 9).flat_map(|i| (0..4).map(move |p| (i, [p / 2, p % 2]))) {
            let (up, ky, kx) = (i / 9, i / 3 % 3, i % 3);
            let ([b, row], [c, column]) = (seen(parity[0], ky), seen(parity[1], kx));
            let row_of_up = up * 4 + b * 2 + c;
            let range = ranges[row_of_up].clone();
            let source = &by_up[row_of_up * lows..][range.clone()];
            let target = &mut sums[tap(parity, [row, column]) * lows..][range];
            let weight = parts.conv(output, up, ky, kx);
            target.iter_mut().zip(source).for_each(|(sum, value)| *sum += weight * value);
        }
        folded.extend(sums.into_iter().map(|sum| sum as f32));
    }
    folded
}

/// The range from the first to the last non-zero value: a single one for nearest upsampling.
fn used(row: &[f64]) -> std::ops::Range<usize> {
    let is_used = |value: &f64| *value != 0.0;
    let first = row.iter().position(is_used).unwrap_or(row.len());
    first..row.iter().rposition(is_used).map_or(first, |last| last + 1)
}

/// The 3×3 convolution's bias plus the transposed one's, through the taps that lie inside.
fn bias(parts: &Parts<'_>) -> Vec<f32> {
    let inside = |place: usize, k: usize| (place, k) != (0, 0) && (place, k) != (2, 2);
    let at = |y: usize, x: usize, output: usize| {
        let taps = (0..9).filter(|tap| inside(y, tap / 3) && inside(x, tap % 3));
        let share = |tap: usize| -> f64 {
            let ups = parts.up_bias.iter().enumerate();
            ups.map(|(up, &b)| f64::from(b) * parts.conv(output, up, tap / 3, tap % 3)).sum()
        };
        (f64::from(parts.conv_bias[output]) + taps.map(share).sum::<f64>()) as f32
    };
    let outputs = parts.conv_bias.len();
    (0..9 * outputs).map(|i| at(i / outputs / 3, i / outputs % 3, i % outputs)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_3x3_tap_falls_into_one_of_two_low_resolution_pixels() {
        // Even outputs see the odd half of the previous pixel, then both halves of their own.
        assert_eq!([0, 1, 2].map(|k| seen(0, k)), [[1, 0], [0, 1], [1, 1]]);
        // Odd outputs see both halves of their own, then the even half of the next pixel.
        assert_eq!([0, 1, 2].map(|k| seen(1, k)), [[0, 0], [1, 0], [0, 1]]);
    }

    #[test]
    fn one_channel_by_hand() {
        // Upsamples with weights 1, 2, 3 and 4, then convolves with only the upper left tap.
        let mut weight = vec![1.0, 2.0, 3.0, 4.0];
        weight.extend([10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let folded = Folded::new(&Params { weight, bias: vec![0.5, 7.0] }, 0, 1, 1);
        // The pixel to the upper left of an even-even one is the last of its block; that of an
        // odd-odd one is the first of its own.
        let found: Vec<_> = (0..16).filter(|&i| folded.low[i] != 0.0).collect();
        let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|parity| tap(parity, [0, 0]));
        assert_eq!(found, corners);
        assert_eq!(corners.map(|i| folded.low[i]), [40.0, 30.0, 20.0, 10.0]);
        // Above and left of the image, upsampled pixels and hence their bias are missing.
        assert_eq!(folded.bias, [7.0, 7.0, 7.0, 7.0, 12.0, 12.0, 7.0, 12.0, 12.0]);
    }
}
