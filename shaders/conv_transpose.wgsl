// Transposed convolution, 2×2 kernel, stride 2, plus bias: every input pixel makes a block of
// 2×2 output pixels, each by its own matrix. One input pixel and four output channels per
// invocation.

import package::common::tensor::{TensorIn, TensorOut, stored};

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [output quad][corner, row-major][input quad]: column j is what input channel j adds to four outputs.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override largest: f32;

fn finish(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    let value = clamp(sum + bias[quad], vec4(-largest), vec4(largest));
    textureStore(output, at, quad, stored(value));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(input));
    let in_quads = textureNumLayers(input);
    let pixel = vec2<i32>(id.xy);
    let out_quad = id.z;

    var upper_left = vec4<f32>();
    var upper_right = vec4<f32>();
    var lower_left = vec4<f32>();
    var lower_right = vec4<f32>();
    for (var quad = 0u; quad < in_quads; quad++) {
        let value = textureLoad(input, min(pixel, size - 1), quad);
        let weight = out_quad * 4u * in_quads + quad;
        upper_left += weights[weight] * value;
        upper_right += weights[weight + in_quads] * value;
        lower_left += weights[weight + 2u * in_quads] * value;
        lower_right += weights[weight + 3u * in_quads] * value;
    }
    if all(pixel < size) {
        finish(upper_left, pixel * 2, out_quad);
        finish(upper_right, pixel * 2 + vec2(1, 0), out_quad);
        finish(lower_left, pixel * 2 + vec2(0, 1), out_quad);
        finish(lower_right, pixel * 2 + vec2(1, 1), out_quad);
    }
}
