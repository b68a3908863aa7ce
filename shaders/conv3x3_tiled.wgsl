// The 3×3 convolution for GPUs. A workgroup makes 16×16 pixels of 16 output channels: for each
// four input channels it stages the pixels with their border and the weights in workgroup
// memory, then every invocation makes 2×2 pixels. Same values as conv3x3.wgsl up to rounding,
// where they are needed.
//
// With the max-pool that follows, the 2×2 pixels of an invocation are also one pixel of the
// pooled tensor. The variant without it is this text less the lines that name `pooled`.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [block of 4 output quads][input quad][tap][output quad]: one mat4x4 as in conv3x3.wgsl.
@group(0) @binding(2) var<storage, read> weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(4) var activity: texture_2d_array<u32>;
@group(0) @binding(5) var<uniform> need: Need;
@group(0) @binding(6) var pooled: TensorOut;

struct Need { layer: u32, shift: u32, reach: u32, padding: u32 }

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

fn activate(sum: vec4<f32>, quad: u32) -> vec4<f32> {
    return clamp(sum + bias[quad], vec4(select(-largest, 0.0, relu)), vec4(largest));
}

fn finish(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, at: vec2<i32>, quad: u32) {
    // Stores outside of the tensor do nothing.
    textureStore(output, at, quad, activate(a, quad));
    textureStore(output, at + vec2(1, 0), quad, activate(b, quad));
    textureStore(output, at + vec2(0, 1), quad, activate(c, quad));
    textureStore(output, at + vec2(1, 1), quad, activate(d, quad));
    textureStore(pooled, at / 2, quad, activate(max(max(a, b), max(c, d)), quad));
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
    // The same for the whole workgroup.
    let distance = textureLoad(activity, corner >> vec2(need.shift), need.layer, 0).x;
    if distance > need.reach {
        return;
    }

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
    finish(a0, b0, c0, d0, at, quad);
    finish(a1, b1, c1, d1, at, quad + 1u);
    finish(a2, b2, c2, d2, at, quad + 2u);
    finish(a3, b3, c3, d3, at, quad + 3u);
}
