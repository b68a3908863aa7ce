// The sums of a 3×3 convolution for GPUs. A workgroup computes 16×16 pixels of 16 output channels:
// for every four input channels it stages the pixels with their border and the weights in workgroup
// memory, then every invocation computes 2×2 pixels.

import package::common::conv_input::{input_quads, input_size, load_input};

// [block of 4 output quads][input quad][tap][output quad]: column j of a matrix holds what input
// channel j adds to four outputs.
@if(input_conv) @group(0) @binding(6) var<storage, read> conv_weights: array<mat4x4<f32>>;
@else @group(0) @binding(2) var<storage, read> conv_weights: array<mat4x4<f32>>;

const TILE = 16u;            // output pixels per side
const STAGED = TILE + 2u;    // with the border
const QUADS = 4u;            // output quads per invocation
const INVOCATIONS = 64u;
@if(up_conv) const TAPS = 16u; // matrices staged at a time, per output quad
@else const TAPS = 9u;

var<workgroup> pixels: array<vec4<f32>, STAGED * STAGED>;
var<workgroup> taps: array<mat4x4<f32>, TAPS * QUADS>;

fn stage_weights(first: u32, count: u32, lane: u32) {
    for (var i = lane; i < count; i += INVOCATIONS) {
        taps[i] = conv_weights[first + i];
    }
}

fn stage(corner: vec2<i32>, quad: u32, block: u32, lane: u32) {
    let size = input_size();
    for (var i = lane; i < STAGED * STAGED; i += INVOCATIONS) {
        let at = corner + vec2<i32>(vec2(i % STAGED, i / STAGED)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = load_input(clamp(at, vec2(0), size - 1), quad);
        pixels[i] = select(vec4<f32>(), texel, inside);
    }
    stage_weights((block * input_quads() + quad) * 9u * QUADS, 9u * QUADS, lane);
}

// Sums of an invocation's 2×2 pixels, a and b above c and d, by output quad. Separate variables,
// because an array indexed in a loop would live in memory.
struct Sums {
    a0: vec4<f32>, a1: vec4<f32>, a2: vec4<f32>, a3: vec4<f32>,
    b0: vec4<f32>, b1: vec4<f32>, b2: vec4<f32>, b3: vec4<f32>,
    c0: vec4<f32>, c1: vec4<f32>, c2: vec4<f32>, c3: vec4<f32>,
    d0: vec4<f32>, d1: vec4<f32>, d2: vec4<f32>, d3: vec4<f32>,
}

// The sums of a block of output quads, without bias, at the pixels starting at `first` in the tile
// of pixels starting at `corner`. The whole workgroup must call it.
fn convolve(corner: vec2<i32>, first: vec2<u32>, block: u32, lane: u32) -> Sums {
    let in_quads = input_quads();
    var s = Sums();
    for (var quad = 0u; quad < in_quads; quad++) {
        workgroupBarrier();
        stage(corner, quad, block, lane);
        workgroupBarrier();
        for (var tap = 0u; tap < 9u; tap++) {
            let base = (first.y + tap / 3u) * STAGED + first.x + tap % 3u;
            let a = pixels[base];
            let b = pixels[base + 1u];
            let c = pixels[base + STAGED];
            let d = pixels[base + STAGED + 1u];
            let w0 = taps[tap * QUADS];
            s.a0 += w0 * a; s.b0 += w0 * b; s.c0 += w0 * c; s.d0 += w0 * d;
            let w1 = taps[tap * QUADS + 1u];
            s.a1 += w1 * a; s.b1 += w1 * b; s.c1 += w1 * c; s.d1 += w1 * d;
            let w2 = taps[tap * QUADS + 2u];
            s.a2 += w2 * a; s.b2 += w2 * b; s.c2 += w2 * c; s.d2 += w2 * d;
            let w3 = taps[tap * QUADS + 3u];
            s.a3 += w3 * a; s.b3 += w3 * b; s.c3 += w3 * c; s.d3 += w3 * d;
        }
    }
    return s;
}
