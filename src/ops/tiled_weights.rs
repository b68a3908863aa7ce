//! The weights of the tiled kernels.

use super::convolution::{PackedWeights, TILED_QUADS, Tiling};
use super::packing::{Taps, storage_buffer};
use crate::gpu::kernel::Context;

/// Output channels of a block.
const OUTPUTS: usize = 4 * TILED_QUADS;

/// `[block of output quads][in_quad][tap][out_quad]` matrices, for each tensor that a kernel reads
/// in turn. [`Tiling::Half`] has 16-bit floats, divided by powers of two, and each block of the
/// first tensor begins with a matrix of its outputs' [`exponents`].
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
    let mut data = Vec::new();
    for (i, taps) in taps.iter().enumerate() {
        let matrices = divided(taps, &exponents);
        for (block, matrices) in matrices.chunks_exact(matrices.len() / blocks(taps)).enumerate() {
            let of = |o: usize| exponents.get(block * OUTPUTS + o).map_or(0.0, |&e| e as f32);
            data.extend((0..OUTPUTS).map(of).filter(|_| i == 0));
            data.extend(matrices);
        }
    }
    data.into_iter().map(half::f16::from_f32).collect()
}

/// The matrices of all blocks, divided by the outputs' powers of two.
fn divided(taps: &Taps<'_>, exponents: &[i32]) -> Vec<f32> {
    let weight = |o: usize, i: usize, tap: usize| {
        (f64::from((taps.weight)(o, i, tap)) / 2_f64.powi(exponents[o])) as f32
    };
    Taps { weight: &weight, ..*taps }.tiled(blocks(taps), TILED_QUADS)
}

/// For each output, the exponent of the power of two that divides its weights, so that the absolute
/// weights of a chunk add up to at most 16/17. As no input exceeds 65504, neither does a chunk's
/// sum, even if each of its 36 products and 36 additions rounds up by 2⁻¹¹, which makes it at most
/// 1.036 times as large. Powers of two cost no precision, except in weights below 2⁻¹⁴ of the
/// divisor.
fn exponents(taps: &[&Taps<'_>]) -> Vec<i32> {
    let largest = |o: usize| taps.iter().map(|taps| largest_sum(taps, o)).fold(0.0, f64::max);
    // The exponents of normal 32-bit floats.
    let exponent = |sum: f64| (sum * 17.0 / 16.0).log2().ceil().clamp(-126.0, 127.0) as i32;
    (0..taps[0].outputs).map(|o| exponent(largest(o))).collect()
}

/// The largest sum of an output's absolute weights over the products of a chunk: four input
/// channels times nine taps, or times the four taps of a parity.
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
