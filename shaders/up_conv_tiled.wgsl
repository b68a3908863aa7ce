// The start of a decoder level for GPUs: 3×3 convolution over the skip and over the
// low-resolution tensor upsampled by a transposed convolution, folded into 2×2 taps by the
// parity of the output's row and column. A workgroup makes 16×16 pixels of 16 output channels:
// for each four input channels it stages the pixels with their border and the weights in
// workgroup memory, then every invocation makes 2×2 pixels, one of each parity.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;

@group(0) @binding(0) var skip: TensorIn;
@group(0) @binding(1) var low: TensorIn;
@group(0) @binding(2) var output: TensorOut;
// Column j of a matrix is what input channel j adds to four outputs. Of the skip
// [block of 4 output quads][skip quad][tap][output quad], then of the low-resolution tensor
// [block][low quad][parity of row, of column, tap row, tap column][output quad].
@group(0) @binding(3) var<storage, read> weights: array<mat4x4<f32>>;
// [above, inside, below][left, inside, right][output quad]
@group(0) @binding(4) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(5) var activity: texture_2d_array<u32>;
@group(0) @binding(6) var<uniform> need: Need;

struct Need { layer: u32, shift: u32, reach: u32, padding: u32 }

override relu: bool;
override largest: f32;

const TILE = 16u;              // output pixels per side
const STAGED = TILE + 2u;      // of the skip, with the border
const LOW = TILE / 2u + 2u;    // of the low-resolution tensor, with the border
const QUADS = 4u;              // output quads per invocation
const INVOCATIONS = 64u;

var<workgroup> pixels: array<vec4<f32>, STAGED * STAGED>;
var<workgroup> taps: array<mat4x4<f32>, 16u * QUADS>;

fn stage_weights(first: u32, count: u32, lane: u32) {
    for (var i = lane; i < count; i += INVOCATIONS) {
        taps[i] = weights[first + i];
    }
}

fn stage_skip(corner: vec2<i32>, quad: u32, lane: u32) {
    let size = vec2<i32>(textureDimensions(skip));
    for (var i = lane; i < STAGED * STAGED; i += INVOCATIONS) {
        let at = corner + vec2<i32>(vec2(i % STAGED, i / STAGED)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = textureLoad(skip, clamp(at, vec2(0), size - 1), quad);
        pixels[i] = select(vec4<f32>(), texel, inside);
    }
}

fn stage_low(corner: vec2<i32>, quad: u32, lane: u32) {
    let size = vec2<i32>(textureDimensions(low));
    for (var i = lane; i < LOW * LOW; i += INVOCATIONS) {
        let at = corner / 2 + vec2<i32>(vec2(i % LOW, i / LOW)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size);
        let texel = textureLoad(low, clamp(at, vec2(0), size - 1), quad);
        pixels[i] = select(vec4<f32>(), texel, inside);
    }
}

fn store(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    let last = vec2<i32>(textureDimensions(output)) - 1;
    let place = select(select(vec2(1), vec2(2), at == last), vec2(0), at == vec2(0));
    let biased = sum + bias[u32(place.y * 3 + place.x) * textureNumLayers(output) + quad];
    let floor = select(-largest, 0.0, relu);
    // Stores outside of the tensor do nothing.
    textureStore(output, at, quad, stored(clamp(biased, vec4(floor), vec4(largest))));
}

fn finish(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, at: vec2<i32>, quad: u32) {
    store(a, at, quad);
    store(b, at + vec2(1, 0), quad);
    store(c, at + vec2(0, 1), quad);
    store(d, at + vec2(1, 1), quad);
}

// Accumulators are separate variables, pixel a to d by quad 0 to 3: an array indexed in a loop
// would live in memory.
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

    var a0 = vec4<f32>(); var a1 = vec4<f32>(); var a2 = vec4<f32>(); var a3 = vec4<f32>();
    var b0 = vec4<f32>(); var b1 = vec4<f32>(); var b2 = vec4<f32>(); var b3 = vec4<f32>();
    var c0 = vec4<f32>(); var c1 = vec4<f32>(); var c2 = vec4<f32>(); var c3 = vec4<f32>();
    var d0 = vec4<f32>(); var d1 = vec4<f32>(); var d2 = vec4<f32>(); var d3 = vec4<f32>();
    let skip_quads = textureNumLayers(skip);
    for (var quad = 0u; quad < skip_quads; quad++) {
        workgroupBarrier();
        stage_skip(corner, quad, lane);
        stage_weights((group.z * skip_quads + quad) * 9u * QUADS, 9u * QUADS, lane);
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
    let low_quads = textureNumLayers(low);
    let blocks = (textureNumLayers(output) + QUADS - 1u) / QUADS;
    let low_weights = blocks * skip_quads * 9u * QUADS;
    for (var quad = 0u; quad < low_quads; quad++) {
        workgroupBarrier();
        stage_low(corner, quad, lane);
        let weight = low_weights + (group.z * low_quads + quad) * 16u * QUADS;
        stage_weights(weight, 16u * QUADS, lane);
        workgroupBarrier();
        for (var tap = 0u; tap < 4u; tap++) {
            // Odd columns and rows see one low-resolution pixel further right and down.
            let base = (local.y + tap / 2u) * LOW + local.x + tap % 2u;
            let a = pixels[base];
            let b = pixels[base + 1u];
            let c = pixels[base + LOW];
            let d = pixels[base + LOW + 1u];
            let w = tap * QUADS;
            a0 += taps[w] * a; a1 += taps[w + 1u] * a; a2 += taps[w + 2u] * a; a3 += taps[w + 3u] * a;
            b0 += taps[w + 16u] * b; b1 += taps[w + 17u] * b;
            b2 += taps[w + 18u] * b; b3 += taps[w + 19u] * b;
            c0 += taps[w + 32u] * c; c1 += taps[w + 33u] * c;
            c2 += taps[w + 34u] * c; c3 += taps[w + 35u] * c;
            d0 += taps[w + 48u] * d; d1 += taps[w + 49u] * d;
            d2 += taps[w + 50u] * d; d3 += taps[w + 51u] * d;
        }
    }
    let at = corner + vec2<i32>(first);
    let quad = group.z * QUADS;
    finish(a0, b0, c0, d0, at, quad);
    finish(a1, b1, c1, d1, at, quad + 1u);
    finish(a2, b2, c2, d2, at, quad + 2u);
    finish(a3, b3, c3, d3, at, quad + 3u);
}
