// The 3×3 convolution for GPUs. A workgroup makes 16×16 pixels of 16 output channels: for each
// four input channels it stages the pixels with their border and the weights in workgroup
// memory, then every invocation makes 2×2 pixels. Same values as conv3x3.wgsl up to rounding.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [block of 4 output quads][input quad][tap][output quad]: one mat4x4 as in conv3x3.wgsl.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override relu: bool;
override largest: f32;

const TILE = 16u;            // output pixels per side
const STAGED = TILE + 2u;    // with the border
const QUADS = 4u;            // output quads per invocation
const INVOCATIONS = 64u;

var<workgroup> pixels: array<vec4<f32>, STAGED * STAGED>;
var<workgroup> taps: array<mat4x4<f32>, 9u * QUADS>;

fn stage(corner: vec2<i32>, size: vec2<i32>, quad: u32, block: u32, in_quads: u32, lane: u32) {
    for (var i = lane; i < STAGED * STAGED; i += INVOCATIONS) {
        let at = corner + vec2<i32>(vec2(i % STAGED, i / STAGED)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = textureLoad(input, clamp(at, vec2(0), size - 1), quad);
        pixels[i] = select(vec4<f32>(), texel, inside);
    }
    for (var i = lane; i < 9u * QUADS; i += INVOCATIONS) {
        taps[i] = weights[(block * in_quads + quad) * 9u * QUADS + i];
    }
}

fn finish(sum: vec4<f32>, at: vec2<i32>, size: vec2<i32>, quad: u32) {
    let floor = select(-largest, 0.0, relu);
    if all(at < size) && quad < textureNumLayers(output) {
        let value = clamp(sum + bias[quad], vec4(floor), vec4(largest));
        textureStore(output, at, quad, value);
    }
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let size = vec2<i32>(textureDimensions(output));
    let in_quads = textureNumLayers(input);
    let corner = vec2<i32>(group.xy * TILE);
    let first = local.xy * 2u;

    var sums: array<array<vec4<f32>, QUADS>, 4>;
    for (var quad = 0u; quad < in_quads; quad++) {
        workgroupBarrier();
        stage(corner, size, quad, group.z, in_quads, lane);
        workgroupBarrier();
        for (var tap = 0u; tap < 9u; tap++) {
            let base = (first.y + tap / 3u) * STAGED + first.x + tap % 3u;
            let a = pixels[base];
            let b = pixels[base + 1u];
            let c = pixels[base + STAGED];
            let d = pixels[base + STAGED + 1u];
            for (var k = 0u; k < QUADS; k++) {
                let weight = taps[tap * QUADS + k];
                for (var j = 0u; j < 4u; j++) {
                    sums[0][k] += weight[j] * a[j];
                    sums[1][k] += weight[j] * b[j];
                    sums[2][k] += weight[j] * c[j];
                    sums[3][k] += weight[j] * d[j];
                }
            }
        }
    }
    for (var p = 0u; p < 4u; p++) {
        let at = corner + vec2<i32>(first + vec2(p % 2u, p / 2u));
        for (var k = 0u; k < QUADS; k++) {
            finish(sums[p][k], at, size, group.z * QUADS + k);
        }
    }
}
