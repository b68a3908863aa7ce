// 3×3 convolution with zero padding of 1, plus bias, plus an optional ReLU.
// The readable definition: one pixel and four output channels per invocation.

import package::common::tensor::{TensorIn, TensorOut, stored};

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [output quad][tap, row-major][input quad]: column j is what input channel j adds to four outputs.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override relu: bool;
// The largest value that the tensor's format holds: f32 to f16 does not saturate by itself.
override largest: f32;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(output));
    let in_quads = textureNumLayers(input);
    let pixel = vec2<i32>(id.xy);
    let out_quad = id.z;

    var sum = vec4<f32>();
    for (var tap = 0u; tap < 9u; tap++) {
        let at = pixel + vec2<i32>(vec2(tap % 3u, tap / 3u)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        for (var quad = 0u; quad < in_quads; quad++) {
            let texel = textureLoad(input, clamp(at, vec2(0), size - 1), quad);
            let value = select(vec4<f32>(), texel, inside);
            sum += weights[(out_quad * 9u + tap) * in_quads + quad] * value;
        }
    }
    sum += bias[out_quad];
    let floor = select(-largest, 0.0, relu);
    if all(pixel < size) {
        textureStore(output, pixel, out_quad, stored(clamp(sum, vec4(floor), vec4(largest))));
    }
}
