// The sums of a 3×3 convolution for GPUs. A workgroup computes 16 output channels of 16×16 pixels,
// or of 32×8 in the wide set. For every four input channels, eight in the wide set, it stages the
// pixels with their border and the weights in workgroup memory; then every invocation computes 2×2
// pixels.

import package::common::conv_input::{input_quads, input_size, load_input};
import package::common::sums::{ChunkSums, Number, Sums, Taps, plus, staged};
@if(half) import package::common::sums::collected;

// [block of 4 output quads][input quad][tap][output quad]. In the half set, a block begins with a
// matrix of exponents. Column q belongs to output quad q, whose weights are divided by these powers
// of two, so that no sum of a chunk exceeds 16 bits.
@if(input_conv) @group(0) @binding(6) var<storage, read> conv_weights: array<Taps>;
@else @group(0) @binding(2) var<storage, read> conv_weights: array<Taps>;

@if(half) const EXPONENTS = 1u;
@else const EXPONENTS = 0u;

// Output pixels of a workgroup, and input quads staged at a time.
@if(wide) const WIDTH = 32u;
@else const WIDTH = 16u;
@if(wide) const HEIGHT = 8u;
@else const HEIGHT = 16u;
@if(wide) const CHUNK = 2u;
@else const CHUNK = 1u;

const STAGED_WIDTH = WIDTH + 2u;
const STAGED = STAGED_WIDTH * (HEIGHT + 2u);
const QUADS = 4u;            // output quads per invocation
const INVOCATIONS = 64u;
// Matrices staged at a time: 9 taps, or the 16 of the low-resolution tensor of up_conv.
@if(up_conv && !wide) const MATRICES = 16u * QUADS;
@else const MATRICES = 9u * QUADS * CHUNK;

var<workgroup> pixels: array<vec4<Number>, STAGED * CHUNK>;
var<workgroup> taps: array<Taps, MATRICES>;

// The invocation's square of 2×2 pixels, counted in squares.
fn square_of(lane: u32) -> vec2<u32> {
    return vec2(lane % (WIDTH / 2u), lane / (WIDTH / 2u));
}

// The number of matrices in this many blocks.
fn matrices_of(blocks: u32) -> u32 {
    return blocks * (EXPONENTS + input_quads() * 9u * QUADS);
}

@if(half)
fn scales_of(block: u32) -> mat4x4<f32> {
    let exponents = conv_weights[matrices_of(block)];
    return mat4x4<f32>(
        ldexp(vec4(1.0), vec4<i32>(exponents[0])), ldexp(vec4(1.0), vec4<i32>(exponents[1])),
        ldexp(vec4(1.0), vec4<i32>(exponents[2])), ldexp(vec4(1.0), vec4<i32>(exponents[3])),
    );
}

fn stage_weights(first: u32, count: u32, lane: u32) {
    for (var i = lane; i < count; i += INVOCATIONS) {
        taps[i] = conv_weights[first + i];
    }
}

fn stage_pixels(corner: vec2<i32>, quad: u32, place: u32, lane: u32) {
    let size = input_size();
    for (var i = lane; i < STAGED; i += INVOCATIONS) {
        let at = corner + vec2<i32>(vec2(i % STAGED_WIDTH, i / STAGED_WIDTH)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = load_input(clamp(at, vec2(0), size - 1), quad);
        pixels[place + i] = staged(select(vec4<f32>(), texel, inside));
    }
}

// The sums of a block of output quads, without bias, at an invocation's pixels in the tile that
// starts at `corner`. The whole workgroup must call it.
fn convolve(corner: vec2<i32>, block: u32, lane: u32) -> Sums {
    let pixel = square_of(lane) * 2u;
    let in_quads = input_quads();
    let weights = matrices_of(block) + EXPONENTS;
    @if(half) let scales = scales_of(block);
    @if(half) var all = Sums();
    var s = ChunkSums();
    for (var first = 0u; first < in_quads; first += CHUNK) {
        let count = min(CHUNK, in_quads - first);
        workgroupBarrier();
        for (var i = 0u; i < count; i++) {
            stage_pixels(corner, first + i, i * STAGED, lane);
        }
        stage_weights(weights + first * 9u * QUADS, 9u * QUADS * count, lane);
        workgroupBarrier();
        for (var i = 0u; i < count; i++) {
            let corner_of_taps = i * STAGED + pixel.y * STAGED_WIDTH + pixel.x;
            for (var tap = 0u; tap < 9u; tap++) {
                let base = corner_of_taps + tap / 3u * STAGED_WIDTH + tap % 3u;
                let a = pixels[base];
                let b = pixels[base + 1u];
                let c = pixels[base + STAGED_WIDTH];
                let d = pixels[base + STAGED_WIDTH + 1u];
                let w = (i * 9u + tap) * QUADS;
                let w0 = taps[w];
                s.a0 = plus(s.a0, w0, a); s.b0 = plus(s.b0, w0, b);
                s.c0 = plus(s.c0, w0, c); s.d0 = plus(s.d0, w0, d);
                let w1 = taps[w + 1u];
                s.a1 = plus(s.a1, w1, a); s.b1 = plus(s.b1, w1, b);
                s.c1 = plus(s.c1, w1, c); s.d1 = plus(s.d1, w1, d);
                let w2 = taps[w + 2u];
                s.a2 = plus(s.a2, w2, a); s.b2 = plus(s.b2, w2, b);
                s.c2 = plus(s.c2, w2, c); s.d2 = plus(s.d2, w2, d);
                let w3 = taps[w + 3u];
                s.a3 = plus(s.a3, w3, a); s.b3 = plus(s.b3, w3, b);
                s.c3 = plus(s.c3, w3, c); s.d3 = plus(s.d3, w3, d);
            }
        }
        @if(half) {
            all = collected(all, s, scales);
            s = ChunkSums();
        }
    }
    @if(half) return all;
    @else return s;
}
