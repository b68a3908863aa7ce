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

fn finish(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    let inside = all(at < vec2<i32>(textureDimensions(output)));
    if inside && quad < textureNumLayers(output) {
        let floor = select(-largest, 0.0, relu);
        textureStore(output, at, quad, clamp(sum + bias[quad], vec4(floor), vec4(largest)));
    }
}

// Accumulators are separate variables, pixel a to d by quad 0 to 3: an array indexed in a loop
// would live in memory.
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

    var a0 = vec4<f32>(); var a1 = vec4<f32>(); var a2 = vec4<f32>(); var a3 = vec4<f32>();
    var b0 = vec4<f32>(); var b1 = vec4<f32>(); var b2 = vec4<f32>(); var b3 = vec4<f32>();
    var c0 = vec4<f32>(); var c1 = vec4<f32>(); var c2 = vec4<f32>(); var c3 = vec4<f32>();
    var d0 = vec4<f32>(); var d1 = vec4<f32>(); var d2 = vec4<f32>(); var d3 = vec4<f32>();
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
            let w0 = taps[tap * QUADS];
            a0 += w0 * a; b0 += w0 * b; c0 += w0 * c; d0 += w0 * d;
            let w1 = taps[tap * QUADS + 1u];
            a1 += w1 * a; b1 += w1 * b; c1 += w1 * c; d1 += w1 * d;
            let w2 = taps[tap * QUADS + 2u];
            a2 += w2 * a; b2 += w2 * b; c2 += w2 * c; d2 += w2 * d;
            let w3 = taps[tap * QUADS + 3u];
            a3 += w3 * a; b3 += w3 * b; c3 += w3 * c; d3 += w3 * d;
        }
    }
    let at = corner + vec2<i32>(first);
    let quad = group.z * QUADS;
    finish(a0, at, quad); finish(a1, at, quad + 1u);
    finish(a2, at, quad + 2u); finish(a3, at, quad + 3u);
    let right = at + vec2(1, 0);
    finish(b0, right, quad); finish(b1, right, quad + 1u);
    finish(b2, right, quad + 2u); finish(b3, right, quad + 3u);
    let below = at + vec2(0, 1);
    finish(c0, below, quad); finish(c1, below, quad + 1u);
    finish(c2, below, quad + 2u); finish(c3, below, quad + 3u);
    let across = at + vec2(1, 1);
    finish(d0, across, quad); finish(d1, across, quad + 1u);
    finish(d2, across, quad + 2u); finish(d3, across, quad + 3u);
}
