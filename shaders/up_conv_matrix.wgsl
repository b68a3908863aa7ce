// The start of a decoder level on matrix units: its low-resolution tensor. A row of its pixels
// serves both rows of a subgroup, in even and in odd columns, each of the four with taps of its
// own.

import package::common::conv_output::output;
import package::common::matrix::{CHANNELS, QUADS, SIDE, SUBGROUPS, input_slices, keep};
import package::common::tensor::TensorIn;

@group(0) @binding(6) var low: TensorIn;

const LOW_ROW = (SIDE + 2u) * SIDE;

fn low_slices() -> u32 {
    return (textureNumLayers(low) + QUADS - 1u) / QUADS;
}

// Where the weights of the low-resolution tensor begin, after the skip's.
fn low_weights() -> u32 {
    let blocks = (textureNumLayers(output) * 4u + CHANNELS - 1u) / CHANNELS;
    return blocks * input_slices() * 9u * CHANNELS * SIDE;
}

// Stages the pixels of a slice with their border, as `stage` does for the skip.
fn stage_low(corner: vec2<i32>, slice: u32, index: u32, invocations: u32) {
    let size = vec2<i32>(textureDimensions(low));
    let last = textureNumLayers(low) - 1u;
    for (var i = index; i < LOW_ROW / 4u * (SUBGROUPS + 2u); i += invocations) {
        let quad = slice * QUADS + i % QUADS;
        let at = corner + vec2<i32>(vec2(i / QUADS % (SIDE + 2u), i / QUADS / (SIDE + 2u))) - 1;
        let inside = all(at >= vec2(0)) && all(at < size) && quad <= last;
        let texel = textureLoad(low, clamp(at, vec2(0), size - 1), min(quad, last));
        keep(i * 4u, texel, inside);
    }
}
