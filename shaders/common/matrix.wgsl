// Shared by the convolutions on matrix units. A workgroup of SUBGROUPS subgroups computes CHANNELS
// output channels of WIDTH × HEIGHT pixels, each subgroup two rows of them. A slice of SIDE input
// channels is staged at a time. Generated code multiplies; it cannot address the elements of a
// matrix, so sums also pass through workgroup memory.
//
// Even and odd columns are kept apart: row j of a matrix is pixel 2j or 2j + 1. So a subgroup has
// four sums at every place, those of a square of 2×2 pixels.

import package::common::conv_bias::bias_at;
import package::common::conv_input::{input_quads, input_size, load_input};
import package::common::conv_output::{activated, output};
@if(factor_f16) import package::common::limits::LARGEST_F16;
@else import package::common::limits::LARGEST_F32;
import package::common::need::is_needed;

@if(factor_f16) enable f16;

@if(factor_f16) alias Factor = f16;
@else alias Factor = f32;

@if(factor_f16) const LARGEST_FACTOR = LARGEST_F16;
@else const LARGEST_FACTOR = LARGEST_F32;

// Rows and columns of a matrix.
@if(side_16) const SIDE = 16u;
@else const SIDE = 8u;

// Output channels per workgroup.
@if(channels_32) const CHANNELS = 32u;
@else const CHANNELS = 16u;

const QUADS = SIDE / 4u;     // input quads of a slice
const SUBGROUPS = 4u;
const WIDTH = 2u * SIDE;
const HEIGHT = 2u * SUBGROUPS;
const HALF = SIDE + 1u;      // staged pixels of a row in even columns, and as many in odd ones
const ROW = 2u * HALF * SIDE;
const STAGED = ROW * (HEIGHT + 2u);
const SUMS = 256u;           // sums of a subgroup in flight to the output at a time
// The sums actually used: of as many matrices as fit, or as the output channels need.
const SUMS_USED = SIDE * SIDE * min(SUMS / (SIDE * SIDE), CHANNELS / SIDE);

// For the input tensor, then for the low-resolution one, if there is one:
// [block of output channels][slice of input channels][tap][output channel][input channel]
@if(input_conv) @group(0) @binding(6) var<storage, read> weights: array<Factor>;
@else @group(0) @binding(2) var<storage, read> weights: array<Factor>;

var<workgroup> pixels: array<Factor, STAGED>;
var<workgroup> sums: array<f32, SUBGROUPS * SUMS>;
// Whether the tile is needed. Products must run in control flow that is known to be uniform. A
// value from a texture is not, but the result of workgroupUniformLoad is.
var<workgroup> needed: bool;

fn decide(corner: vec2<i32>, index: u32) {
    if index == 0u {
        needed = is_needed(corner);
    }
}

// Stages four channels of a pixel; outside the image, all are 0.
fn keep(place: u32, texel: vec4<f32>, inside: bool) {
    let most = vec4(LARGEST_FACTOR);
    let value = vec4<Factor>(clamp(select(vec4<f32>(), texel, inside), -most, most));
    pixels[place] = value.x;
    pixels[place + 1u] = value.y;
    pixels[place + 2u] = value.z;
    pixels[place + 3u] = value.w;
}

fn input_slices() -> u32 {
    return (input_quads() + QUADS - 1u) / QUADS;
}

// Stages the pixels of a slice with their border. Weights of missing channels are 0.
fn stage(corner: vec2<i32>, slice: u32, index: u32, invocations: u32) {
    let size = input_size();
    let last = input_quads() - 1u;
    for (var i = index; i < STAGED / 4u; i += invocations) {
        let quad = slice * QUADS + i % QUADS;
        let x = i / QUADS % (2u * HALF);
        let y = i / QUADS / (2u * HALF);
        let at = corner + vec2<i32>(vec2(x, y)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size) && quad <= last;
        let texel = load_input(clamp(at, vec2(0), size - 1), min(quad, last));
        keep(y * ROW + column(x) + i % QUADS * 4u, texel, inside);
    }
}

// Where a staged row keeps column x. The columns x, x + 2, x + 4, … follow each other.
fn column(x: u32) -> u32 {
    return (x % 2u * HALF + x / 2u) * SIDE;
}

// A quad of pixel x, from the sums [output channel][pixel] that start at `place`.
fn sum_of(place: u32, x: u32, quad: u32) -> vec4<f32> {
    let first = place + quad * 4u * SIDE + x;
    let below = vec2(sums[first], sums[first + SIDE]);
    let above = vec2(sums[first + 2u * SIDE], sums[first + 3u * SIDE]);
    return vec4(below, above);
}

// Finishes and stores the `i`th quad of the sums that start at `place`, and returns what it stored.
// `at` is the first pixel's position; the others follow in every other column.
fn put(at: vec2<i32>, quad: u32, place: u32, i: u32) -> vec4<f32> {
    let pixel = at + vec2(2 * i32(i % SIDE), 0);
    let sum = sum_of(place, i % SIDE, i / SIDE);
    let value = activated(sum + bias_at(pixel, quad + i / SIDE));
    // Stores outside the tensor do nothing.
    if i < SUMS_USED / 4u {
        textureStore(output, pixel, quad + i / SIDE, value);
    }
    return value;
}
