// 1×1 convolution plus bias: a matrix per pixel. One pixel and four output channels per invocation.

import package::common::tensor::{TensorIn, TensorOut, stored};

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [output quad][input quad]: column j is what input channel j adds to four outputs.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override largest: f32;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(output));
    let in_quads = textureNumLayers(input);
    let pixel = vec2<i32>(id.xy);
    let out_quad = id.z;

    var sum = vec4<f32>();
    for (var quad = 0u; quad < in_quads; quad++) {
        let value = textureLoad(input, min(pixel, size - 1), quad);
        sum += weights[out_quad * in_quads + quad] * value;
    }
    sum += bias[out_quad];
    if all(pixel < size) {
        let value = clamp(sum, vec4(-largest), vec4(largest));
        textureStore(output, pixel, out_quad, stored(value));
    }
}
