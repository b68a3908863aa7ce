// The start of a decoder level for GPUs: a 3×3 convolution over the skip and over the
// low-resolution tensor upsampled by a transposed convolution. The second part is folded into 2×2
// taps for each parity of the output's row and column. The skip is the `input` of the 3×3
// convolution.

import package::common::conv_output::output;
import package::common::conv_sums::{
    HEIGHT, INVOCATIONS, QUADS, WIDTH, matrices_of, pixels, square_of, stage_weights, taps
};
@if(half) import package::common::conv_sums::scales_of;
import package::common::conv_tile::make_tile;
import package::common::sums::{Sums, plus, staged};
@if(half) import package::common::sums::{ChunkSums, collected};
import package::common::tensor::TensorIn;

@group(0) @binding(6) var low: TensorIn;

// Staged pixels of the low-resolution tensor, with the border.
const LOW_WIDTH = WIDTH / 2u + 2u;
const LOW = LOW_WIDTH * (HEIGHT / 2u + 2u);

fn stage_low(corner: vec2<i32>, quad: u32, lane: u32) {
    let size = vec2<i32>(textureDimensions(low));
    for (var i = lane; i < LOW; i += INVOCATIONS) {
        let at = corner / 2 + vec2<i32>(vec2(i % LOW_WIDTH, i / LOW_WIDTH)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = textureLoad(low, clamp(at, vec2(0), size - 1), quad);
        pixels[i] = staged(select(vec4<f32>(), texel, inside));
    }
}

// Adds the sums of the low-resolution tensor to the skip's. Its weights follow the skip's:
// [block][low quad][parity of row, of column, tap row, tap column][output quad].
fn convolve_low(skip: Sums, corner: vec2<i32>, block: u32, lane: u32) -> Sums {
    let square = square_of(lane);
    @if(half) let scales = scales_of(block);
    @if(half) var all = skip;
    @if(half) var s = ChunkSums();
    @else var s = skip;
    let low_quads = textureNumLayers(low);
    let blocks = (textureNumLayers(output) + QUADS - 1u) / QUADS;
    let low_weights = matrices_of(blocks);
    for (var quad = 0u; quad < low_quads; quad++) {
        workgroupBarrier();
        stage_low(corner, quad, lane);
        let weight = low_weights + (block * low_quads + quad) * 16u * QUADS;
        stage_weights(weight, 16u * QUADS, lane);
        workgroupBarrier();
        for (var tap = 0u; tap < 4u; tap++) {
            // Odd columns and rows see one low-resolution pixel further right and down.
            let base = (square.y + tap / 2u) * LOW_WIDTH + square.x + tap % 2u;
            let a = pixels[base];
            let b = pixels[base + 1u];
            let c = pixels[base + LOW_WIDTH];
            let d = pixels[base + LOW_WIDTH + 1u];
            let w = tap * QUADS;
            s.a0 = plus(s.a0, taps[w], a); s.a1 = plus(s.a1, taps[w + 1u], a);
            s.a2 = plus(s.a2, taps[w + 2u], a); s.a3 = plus(s.a3, taps[w + 3u], a);
            s.b0 = plus(s.b0, taps[w + 16u], b); s.b1 = plus(s.b1, taps[w + 17u], b);
            s.b2 = plus(s.b2, taps[w + 18u], b); s.b3 = plus(s.b3, taps[w + 19u], b);
            s.c0 = plus(s.c0, taps[w + 32u], c); s.c1 = plus(s.c1, taps[w + 33u], c);
            s.c2 = plus(s.c2, taps[w + 34u], c); s.c3 = plus(s.c3, taps[w + 35u], c);
            s.d0 = plus(s.d0, taps[w + 48u], d); s.d1 = plus(s.d1, taps[w + 49u], d);
            s.d2 = plus(s.d2, taps[w + 50u], d); s.d3 = plus(s.d3, taps[w + 51u], d);
        }
        @if(half) {
            all = collected(all, s, scales);
            s = ChunkSums();
        }
    }
    @if(half) return all;
    @else return s;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    make_tile(group, lane);
}
