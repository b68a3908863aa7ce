// The 3×3 convolution on matrix units: what the generated code calls. A workgroup of SUBGROUPS
// subgroups makes CHANNELS output channels of WIDTH × HEIGHT pixels.

import package::common::conv_output::{activated, bias, output};
@if(factor_f16) import package::common::limits::LARGEST_F16;
@else import package::common::limits::LARGEST_F32;
import package::common::tensor::TensorIn;

@if(factor_f16) enable f16;

@if(factor_f16) alias Factor = f16;
@else alias Factor = f32;

@if(factor_f16) const LARGEST_FACTOR = LARGEST_F16;
@else const LARGEST_FACTOR = LARGEST_F32;

// Rows and columns of a matrix.
@if(side_16) const SIDE = 16u;
@else const SIDE = 8u;

// Output channels of a workgroup.
@if(channels_32) const CHANNELS = 32u;
@else const CHANNELS = 16u;

const QUADS = SIDE / 4u;     // input quads of a slice
const COLUMNS = 2u;          // matrices side by side along a row of pixels
const ROWS = 2u;             // rows of pixels of a subgroup
const SUBGROUPS = 4u;
const WIDTH = COLUMNS * SIDE;
const HEIGHT = SUBGROUPS * ROWS;
const STAGED_WIDTH = WIDTH + 2u;
const STAGED = STAGED_WIDTH * (HEIGHT + 2u);
const SUMS = 256u;           // sums of a subgroup that are on their way to the output at a time
// Those of them that are used: of as many matrices as fit, or as the output channels need.
const SUMS_USED = SIDE * SIDE * min(SUMS / (SIDE * SIDE), CHANNELS / SIDE);

@group(0) @binding(0) var input: TensorIn;
// [block of output channels][slice of input channels][tap][output channel][input channel]
@group(0) @binding(2) var<storage, read> weights: array<Factor>;

var<workgroup> pixels: array<Factor, STAGED * SIDE>;
var<workgroup> sums: array<f32, SUBGROUPS * SUMS>;

// Stages the pixels of a slice with their border. What lies outside of the image or its channels is
// 0, and so are the weights of channels that do not exist.
fn stage(corner: vec2<i32>, slice: u32, index: u32, invocations: u32) {
    let size = vec2<i32>(textureDimensions(input));
    let in_quads = textureNumLayers(input);
    for (var i = index; i < STAGED * QUADS; i += invocations) {
        let quad = slice * QUADS + i % QUADS;
        let at = corner + vec2<i32>(vec2(i / QUADS % STAGED_WIDTH, i / QUADS / STAGED_WIDTH)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size) && quad < in_quads;
        let texel = textureLoad(input, clamp(at, vec2(0), size - 1), min(quad, in_quads - 1u));
        let most = vec4(LARGEST_FACTOR);
        let value = vec4<Factor>(clamp(select(vec4<f32>(), texel, inside), -most, most));
        pixels[i * 4u] = value.x;
        pixels[i * 4u + 1u] = value.y;
        pixels[i * 4u + 2u] = value.z;
        pixels[i * 4u + 3u] = value.w;
    }
}

fn finish(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    let inside = all(at < vec2<i32>(textureDimensions(output)));
    if inside && quad < textureNumLayers(output) {
        textureStore(output, at, quad, activated(sum + bias[quad]));
    }
}

// Stores the sums from `place` on, which are [output channel][pixel of a row]. A subgroup has `lanes`
// invocations.
fn put(at: vec2<i32>, quad: u32, place: u32, lane: u32, lanes: u32) {
    for (var i = lane; i < SUMS_USED / 4u; i += lanes) {
        let x = i % SIDE;
        let first = place + i / SIDE * 4u * SIDE + x;
        let below = vec2(sums[first], sums[first + SIDE]);
        let above = vec2(sums[first + 2u * SIDE], sums[first + 3u * SIDE]);
        finish(vec4(below, above), at + vec2(i32(x), 0), quad + i / SIDE);
    }
}
