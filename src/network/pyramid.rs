//! The end of a network that predicts a kernel pyramid: the calls from its logits to the image.

use super::call::Call;
use crate::gpu::kernel::Context;
use crate::gpu::tensor::GpuTensor;
use crate::ops::activity::Activity;
use crate::ops::gather::{gather, gather_finest};
use crate::ops::output_process::ResultImages;
use crate::ops::pyramid::{NoisyColor, pyramid, pyramid_finest, pyramid_level0};

/// Bytes of a pixel: a color and its weight as 32-bit floats.
const PIXEL_BYTES: u64 = 16;

/// GPU memory in bytes for the pyramid of a tile and its results, of which level 0 is the image.
pub(crate) fn bytes(tile: [u32; 2], levels: usize, stores_level0: bool) -> u64 {
    let level = |l| tile.map(|side| u64::from(side >> l)).iter().product::<u64>();
    let level0 = if stores_level0 { level(0) } else { 0 };
    PIXEL_BYTES * (level0 + 2 * (1..levels).map(level).sum::<u64>())
}

/// The calls from the logits, by level, to the image.
pub(super) fn calls(
    context: &Context,
    tile: [u32; 2],
    logits: &[&GpuTensor],
    stores_level0: bool,
    activity: &Activity,
    images: &ResultImages<'_>,
) -> Vec<Call> {
    let light = |l: usize| GpuTensor::light(context, tile.map(|side| side >> l));
    let level0 = stores_level0.then(|| light(0));
    let levels: Vec<_> = (1..logits.len()).map(light).collect();
    let results: Vec<_> = (1..logits.len()).map(light).collect();
    let mut calls = beginning(context, images, logits, level0.as_ref(), &levels[0]);
    calls.extend(descent(context, logits, &levels));
    calls.extend(ascent(context, logits, &levels, &results));
    let finest = [logits[0], &results[0]];
    let last = gather_finest(context, finest, level0.as_ref(), activity, images);
    let light: Vec<_> = [&results[0]].into_iter().chain(&level0).collect();
    calls.push(Call::per_tile("gather0", last).moving(context, &logits[..1], &light));
    calls
}

/// From the noisy color to level 1, with or without storing level 0.
fn beginning(
    context: &Context,
    images: &ResultImages<'_>,
    logits: &[&GpuTensor],
    level0: Option<&GpuTensor>,
    level1: &GpuTensor,
) -> Vec<Call> {
    let ResultImages { tiles, color, input_scale, encoding, .. } = *images;
    let noisy = NoisyColor { tiles, color, input_scale, encoding };
    let read = [0, 1].map(|l| confidences(logits[l]));
    let Some(level0) = level0 else {
        let call = pyramid_finest(context, &noisy, [logits[0], logits[1]], level1);
        let call = Call::per_tile("pyramid1", call);
        return vec![call.moving(context, &[&read[0], &read[1]], &[level1])];
    };
    let call = pyramid_level0(context, &noisy, logits[0], level0);
    let first = Call::per_tile("pyramid0", call).moving(context, &[&read[0]], &[level0]);
    vec![first, level(context, 1, level0, logits[1], level1)]
}

/// From level 1 to the coarsest. `levels` begin at level 1.
fn descent(context: &Context, logits: &[&GpuTensor], levels: &[GpuTensor]) -> Vec<Call> {
    let call = |l: usize| level(context, l, &levels[l - 2], logits[l], &levels[l - 1]);
    (2..logits.len()).map(call).collect()
}

/// Level `l` from the finer one.
fn level(
    context: &Context,
    l: usize,
    finer: &GpuTensor,
    logits: &GpuTensor,
    level: &GpuTensor,
) -> Call {
    let call = Call::fixed(&format!("pyramid{l}"), pyramid(context, finer, logits, level));
    call.moving(context, &[&confidences(logits)], &[finer, level])
}

/// The quad of logits that has the confidence, all that the pyramid reads of them. For counting.
fn confidences(logits: &GpuTensor) -> GpuTensor {
    GpuTensor { quads: 1, ..logits.clone() }
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
