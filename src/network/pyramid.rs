//! The end of a network that predicts a kernel pyramid: the calls from its logits to the image.

use super::bind::{Bound, Call};
use crate::gpu::kernel::Context;
use crate::gpu::tensor::GpuTensor;
use crate::ops::activity::Activity;
use crate::ops::gather::{gather, gather_finest};
use crate::ops::output_process::ResultImages;
use crate::ops::pyramid::{NoisyColor, pyramid, pyramid_finest};

/// Bytes of a pixel: a color and its weight as 32-bit floats.
const PIXEL_BYTES: u64 = 16;

/// GPU memory in bytes for the pyramid of a tile and its results, which both lack level 0.
pub(crate) fn bytes(tile: [u32; 2], levels: usize) -> u64 {
    let level = |l| tile.map(|side| u64::from(side >> l)).iter().product::<u64>();
    (1..levels).map(|l| 2 * PIXEL_BYTES * level(l)).sum()
}

/// The calls from the logits, by level, to the image.
pub(super) fn calls(
    context: &Context,
    bound: &Bound<'_>,
    logits: &[&GpuTensor],
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Vec<Call> {
    let light = |l: usize| GpuTensor::light(context, bound.tile.map(|side| side >> l));
    let levels: Vec<_> = (1..logits.len()).map(light).collect();
    let results: Vec<_> = (1..logits.len()).map(light).collect();
    let mut calls = descent(context, images, logits, &levels);
    calls.extend(ascent(context, logits, &levels, &results));
    let last = gather_finest(context, [logits[0], &results[0]], activity, images);
    calls.push(Call::per_tile("gather0", last).moving(context, &[logits[0]], &[&results[0]]));
    calls
}

/// From level 1 to the coarsest. `levels` begin at level 1.
fn descent(
    context: &Context,
    images: &ResultImages<'_>,
    logits: &[&GpuTensor],
    levels: &[GpuTensor],
) -> Vec<Call> {
    let ResultImages { tiles, color, input_scale, encoding, .. } = *images;
    let noisy = NoisyColor { tiles, color, input_scale, encoding };
    let first = pyramid_finest(context, &noisy, [logits[0], logits[1]], &levels[0]);
    let first = Call::per_tile("pyramid1", first);
    let mut calls = vec![first.moving(context, &logits[..2], &[&levels[0]])];
    for l in 2..logits.len() {
        let [finer, level] = [&levels[l - 2], &levels[l - 1]];
        let call = Call::fixed(&format!("pyramid{l}"), pyramid(context, finer, logits[l], level));
        calls.push(call.moving(context, &[logits[l]], &[finer, level]));
    }
    calls
}

/// From the coarsest level to level 1. `levels` and `results` begin at level 1.
fn ascent(
    context: &Context,
    logits: &[&GpuTensor],
    levels: &[GpuTensor],
    results: &[GpuTensor],
) -> Vec<Call> {
    let call = |l: usize| {
        let (level, result, coarser) = (&levels[l - 1], &results[l - 1], results.get(l));
        let call = gather(context, [level, logits[l]], coarser, result);
        let light: Vec<_> = [level, result].into_iter().chain(coarser).collect();
        Call::fixed(&format!("gather{l}"), call).moving(context, &[logits[l]], &light)
    };
    (1..logits.len()).rev().map(call).collect()
}
