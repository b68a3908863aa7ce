// Transposed convolution, 2×2 kernel, stride 2, plus bias: every input pixel makes a block of
// 2×2 output pixels, each by its own matrix. One input pixel and four output channels per
// invocation.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [output quad][corner, row-major][input quad]: column j is what input channel j adds to four outputs.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override largest: f32;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(input));
    let in_quads = textureNumLayers(input);
    let pixel = vec2<i32>(id.xy);
    let out_quad = id.z;

    var sums: array<vec4<f32>, 4>;
    for (var quad = 0u; quad < in_quads; quad++) {
        let value = textureLoad(input, min(pixel, size - 1), quad);
        for (var corner = 0u; corner < 4u; corner++) {
            let weight = weights[(out_quad * 4u + corner) * in_quads + quad];
            sums[corner] += weight[0] * value.x;
            sums[corner] += weight[1] * value.y;
            sums[corner] += weight[2] * value.z;
            sums[corner] += weight[3] * value.w;
        }
    }
    if any(pixel >= size) {
        return;
    }
    for (var corner = 0u; corner < 4u; corner++) {
        let at = pixel * 2 + vec2<i32>(vec2(corner % 2u, corner / 2u));
        let value = clamp(sums[corner] + bias[out_quad], vec4(-largest), vec4(largest));
        textureStore(output, at, out_quad, value);
    }
}
