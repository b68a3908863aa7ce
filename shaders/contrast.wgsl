// The albedo's contrast: the logarithm of how much brighter a pixel is than its surroundings. A
// kernel pyramid demodulates light with it (common/demodulation.wgsl).
//
// The surroundings are the means over aligned blocks of `side` pixels, upsampled bilinearly.
// `average` computes the means, one block per invocation; `compare` stores the contrast, one pixel
// of the tile per invocation. Where the albedo is constant, the contrast is exactly 0.

import package::common::place::place;
import package::common::reflectance::reflectance;
import package::common::tensor::{TensorOut, stored};

// One vector per block of the tile, row by row.
@group(0) @binding(1) var<storage, read_write> means: array<vec4<f32>>;
@group(0) @binding(3) var output: TensorOut;

override side: u32;          // of a block in pixels, a power of two

const FLOOR = 0.05;          // added to the albedo, so that noise in black is no contrast

fn blocks() -> vec2<u32> {
    return textureDimensions(output) / side;
}

@compute @workgroup_size(8, 8)
fn average(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= blocks()) {
        return;
    }
    var sum = vec3<f32>();
    var least = vec3(1.0);
    var most = vec3<f32>();
    for (var i = 0u; i < side * side; i++) {
        let value = reflectance(place(id.xy * side + vec2(i % side, i / side)));
        sum += value;
        least = min(least, value);
        most = max(most, value);
    }
    // Rounding may not lead out of the block's range: the mean of a constant is that constant.
    let mean = clamp(sum / f32(side * side), least, most);
    means[id.y * blocks().x + id.x] = vec4(mean, 0.0);
}

// The mean of a block. Beyond the tile, its edge repeats.
fn mean_of(block: vec2<i32>) -> vec3<f32> {
    let at = vec2<u32>(clamp(block, vec2(0), vec2<i32>(blocks()) - 1));
    return means[at.y * blocks().x + at.x].rgb;
}

// The means of the four nearest blocks, bilinear between their centers.
fn mean_around(pixel: vec2<u32>) -> vec3<f32> {
    let at = (vec2<f32>(pixel) + 0.5) / f32(side) - 0.5;
    let first = vec2<i32>(floor(at));
    let share = at - floor(at);
    let a = mean_of(first);
    let b = mean_of(first + vec2(1, 0));
    let c = mean_of(first + vec2(0, 1));
    let d = mean_of(first + vec2(1, 1));
    let mean = mix(mix(a, b, share.x), mix(c, d, share.x), share.y);
    return clamp(mean, min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
}

@compute @workgroup_size(8, 8)
fn compare(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(output)) {
        return;
    }
    let albedo = reflectance(place(id.xy));
    let mean = mean_around(id.xy);
    let contrast = select(log((albedo + FLOOR) / (mean + FLOOR)), vec3(0.0), albedo == mean);
    textureStore(output, id.xy, 0, stored(vec4(contrast, 0.0)));
}
