// The 3×3 convolution for GPUs. A workgroup makes 16×16 pixels of 16 output channels: for each
// four input channels it stages the pixels with their border and the weights in workgroup
// memory, then every invocation makes 2×2 pixels. Same values as conv3x3.wgsl up to rounding,
// where they are needed.
//
// With the max-pool that follows, the 2×2 pixels of an invocation are also one pixel of the
// smaller tensor. The variant without it is this text less the lines with the name of that.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
// [block of 4 output quads][input quad][tap][output quad]: one mat4x4 as in conv3x3.wgsl.
@group(0) @binding(2) var<storage, read> conv_weights: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(4) var activity: texture_2d_array<u32>;
@group(0) @binding(5) var<uniform> need: Need;
@group(0) @binding(6) var pooled: TensorOut;

// What is convolved. From here to `Need` this text is also part of the tiled conv_head, and from
// `TILE` on of the tiled input_conv.

fn input_size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(input));
}

fn input_quads() -> u32 {
    return textureNumLayers(input);
}

fn load_input(at: vec2<i32>, quad: u32) -> vec4<f32> {
    return textureLoad(input, at, quad);
}

const TILE = 16u;            // output pixels per side
const STAGED = TILE + 2u;    // with the border
const QUADS = 4u;            // output quads per invocation
const INVOCATIONS = 64u;

var<workgroup> pixels: array<vec4<f32>, STAGED * STAGED>;
var<workgroup> taps: array<mat4x4<f32>, 9u * QUADS>;

fn stage(corner: vec2<i32>, quad: u32, block: u32, lane: u32) {
    let size = input_size();
    for (var i = lane; i < STAGED * STAGED; i += INVOCATIONS) {
        let at = corner + vec2<i32>(vec2(i % STAGED, i / STAGED)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = load_input(clamp(at, vec2(0), size - 1), quad);
        pixels[i] = select(vec4<f32>(), texel, inside);
    }
    let matrices = (block * input_quads() + quad) * 9u * QUADS;
    for (var i = lane; i < 9u * QUADS; i += INVOCATIONS) {
        taps[i] = conv_weights[matrices + i];
    }
}

// Sums of the 2×2 pixels of an invocation, a and b above c and d, by output quad. Separate
// variables: an array indexed in a loop would live in memory.
struct Sums {
    a0: vec4<f32>, a1: vec4<f32>, a2: vec4<f32>, a3: vec4<f32>,
    b0: vec4<f32>, b1: vec4<f32>, b2: vec4<f32>, b3: vec4<f32>,
    c0: vec4<f32>, c1: vec4<f32>, c2: vec4<f32>, c3: vec4<f32>,
    d0: vec4<f32>, d1: vec4<f32>, d2: vec4<f32>, d3: vec4<f32>,
}

// The sums at the pixels from `first` on of the tile of pixels from `corner` on, without bias,
// of a block of output quads. The whole workgroup must call it.
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

struct Need { layer: u32, shift: u32, reach: u32, padding: u32 }

override relu: bool;
override largest: f32;

fn activate(sum: vec4<f32>, quad: u32) -> vec4<f32> {
    let floor = select(-largest, 0.0, relu);
    return stored(clamp(sum + bias[quad], vec4(floor), vec4(largest)));
}

fn store(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, at: vec2<i32>, quad: u32) {
    // Stores outside of the tensor do nothing.
    textureStore(output, at, quad, activate(a, quad));
    textureStore(output, at + vec2(1, 0), quad, activate(b, quad));
    textureStore(output, at + vec2(0, 1), quad, activate(c, quad));
    textureStore(output, at + vec2(1, 1), quad, activate(d, quad));
    textureStore(pooled, at / 2, quad, activate(max(max(a, b), max(c, d)), quad));
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = vec2<i32>(group.xy * TILE);
    let first = local.xy * 2u;
    // The same for the whole workgroup.
    let distance = textureLoad(activity, corner >> vec2(need.shift), need.layer, 0).x;
    if distance > need.reach {
        return;
    }
    let sums = convolve(corner, first, group.z, lane);
    let at = corner + vec2<i32>(first);
    let quad = group.z * QUADS;
    store(sums.a0, sums.b0, sums.c0, sums.d0, at, quad);
    store(sums.a1, sums.b1, sums.c1, sums.d1, at, quad + 1u);
    store(sums.a2, sums.b2, sums.c2, sums.d2, at, quad + 2u);
    store(sums.a3, sums.b3, sums.c3, sums.d3, at, quad + 3u);
}
