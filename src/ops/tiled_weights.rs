//! The weights of the tiled kernels.

use super::convolution::{PackedWeights, TILED_QUADS, Tiling};
use super::packing::{Taps, storage_buffer};
use crate::gpu::kernel::Context;

/// For one tensor that a kernel reads after the other: `[block of output quads][in_quad][tap]
/// [out_quad]` matrices. [`Tiling::Half`] has 16-bit floats, divided by the powers of two that
/// [`exponents`] gives, and each block of the first tensor begins with a matrix of its exponents.
pub(super) fn tiled_weights(
    context: &Context,
    tiling: Tiling,
    taps: &[&Taps<'_>],
) -> PackedWeights {
    PackedWeights::Buffer(match tiling {
        Tiling::Square | Tiling::Wide => storage_buffer(context, "weights", &matrices(taps)),
        Tiling::Half => storage_buffer(context, "weights", &halves(taps)),
    })
}

fn matrices(taps: &[&Taps<'_>]) -> Vec<f32> {
    taps.iter().flat_map(|taps| taps.tiled(blocks(taps), TILED_QUADS)).collect()
}

fn blocks(taps: &Taps<'_>) -> usize {
    taps.out_quads().div_ceil(TILED_QUADS)
}

fn halves(taps: &[&Taps<'_>]) -> Vec<half::f16> {
    let exponents = exponents(taps);
    let scaled = |taps: &Taps<'_>| {
        let divided = |o: usize, i: usize, tap: usize| {
            (f64::from((taps.weight)(o, i, tap)) / 2_f64.powi(exponents[o])) as f32
        };
        Taps { weight: &divided, ..*taps }.tiled(blocks(taps), TILED_QUADS)
    };
    let [first, others @ ..] = taps else { return Vec::new() };
    let first_matrices = scaled(first);
    let per_block = first_matrices.len() / blocks(first);
    let mut data = Vec::new();
    for (block, matrices) in first_matrices.chunks_exact(per_block).enumerate() {
        let exponent = |i| exponents.get(block * 16 + i).map_or(0.0, |&exponent| exponent as f32);
        data.extend((0..16).map(exponent));
        data.extend(matrices);
    }
    data.extend(others.iter().flat_map(|taps| scaled(taps)));
    data.into_iter().map(half::f16::from_f32).collect()
}

/// For each output, the power of two by which its weights are divided. The absolute weights of a
/// chunk then add up to at most 16/17. As no input exceeds 65504, neither does a chunk's sum, even if
/// each of its 36 products and 36 additions rounds up by 2⁻¹¹, which makes it at most 1.036 times as
/// large. Powers of two cost no precision, except in weights below 2⁻¹⁴ of the divisor.
fn exponents(taps: &[&Taps<'_>]) -> Vec<i32> {
    let largest = |o: usize| taps.iter().map(|taps| largest_sum(taps, o)).fold(0.0, f64::max);
    // As far as 32-bit floats go.
    let exponent = |sum: f64| (sum * 17.0 / 16.0).log2().ceil().clamp(-126.0, 127.0) as i32;
    (0..taps[0].outputs).map(|o| exponent(largest(o))).collect()
}

/// The largest sum of absolute weights of an output over the products of a chunk: four input channels
/// by nine taps, or by the four taps of a parity.
fn largest_sum(taps: &Taps<'_>, output: usize) -> f64 {
    let together = if taps.taps == 16 { 4 } else { taps.taps };
    let chunks = (0..taps.in_quads())
        .flat_map(|quad| (0..taps.taps / together).map(move |group| (quad, group)));
    let sum = |(quad, group): (usize, usize)| -> f64 {
        let products = (0..4 * together).map(|i| (quad * 4 + i % 4, group * together + i / 4));
        products.map(|(i, tap)| f64::from(taps.at(output, i, tap)).abs()).sum()
    };
    chunks.map(sum).fold(0.0, f64::max)
}
