// One level of a kernel pyramid's result: the sum of 3×3 pixels of the level by the softmax of its
// logits, plus the coarser level's result, upsampled and times the share. Four pixels of a row per
// invocation, which share what they read.
// At the finest level, the color of that sum is the image; clean blocks keep their input.

import package::common::gathered::{Nine, gathered};
import package::common::tensor::TensorIn;
import package::common::weighted::{LAST_QUAD, LightIn, share, sum_of_four, sum_of_two};
@if(finest) import package::common::clean::is_clean;
@if(finest) import package::common::finest::{finest, finest_logits};
@if(finest) import package::common::result::{store_linear, store_noisy};
@if(finest) import package::common::tile::tile;
@else import package::common::weighted::LightOut;

@if(!finest) @group(0) @binding(0) var input: LightIn;
@if(!finest) @group(0) @binding(1) var logits: TensorIn;
@if(!finest) @group(0) @binding(2) var output: LightOut;

@if(finest) @group(0) @binding(7) var coarser: LightIn;
@elif(!bottom) @group(0) @binding(3) var coarser: LightIn;

@if(finest)
fn load_logits(pixel: vec2<i32>, quad: u32) -> vec4<f32> {
    return textureLoad(finest_logits, pixel, quad);
}
@else
fn load_logits(pixel: vec2<i32>, quad: u32) -> vec4<f32> {
    return textureLoad(logits, pixel, quad);
}

@if(finest)
fn size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(finest_logits));
}
@else
fn size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(logits));
}

// A pixel of the level. Its edge repeats.
fn at_level(pixel: vec2<i32>) -> vec4<f32> {
    let at = vec2<u32>(clamp(pixel, vec2(0), size() - 1));
    @if(finest)
    return finest(at);
    @else
    return textureLoad(input, at, 0);
}

// Bilinear: of the four nearest coarser pixels, the nearest counts 3/4 along each axis.
@if(!bottom)
fn upsampled(pixel: vec2<i32>) -> vec4<f32> {
    let near = pixel / 2;
    let far = clamp(near + 2 * (pixel & vec2(1)) - 1, vec2(0), size() / 2 - 1);
    return sum_of_four(
        textureLoad(coarser, near, 0),
        textureLoad(coarser, vec2(far.x, near.y), 0),
        textureLoad(coarser, vec2(near.x, far.y), 0),
        textureLoad(coarser, far, 0),
        vec4(9.0, 3.0, 3.0, 1.0) / 16.0,
    );
}

// A pixel and those above and below it.
struct Column {
    above: vec4<f32>, middle: vec4<f32>, below: vec4<f32>,
}

fn column(pixel: vec2<i32>) -> Column {
    return Column(at_level(pixel - vec2(0, 1)), at_level(pixel), at_level(pixel + vec2(0, 1)));
}

fn result(pixel: vec2<i32>, left: Column, center: Column, right: Column) -> vec4<f32> {
    let pixels = Nine(
        left.above, center.above, right.above,
        left.middle, center.middle, right.middle,
        left.below, center.below, right.below,
    );
    let last = load_logits(pixel, LAST_QUAD);
    let own = gathered(pixels, load_logits(pixel, 0u), load_logits(pixel, 1u), last.x);
    @if(bottom)
    return own;
    @else
    return sum_of_two(own, upsampled(pixel), share(last));
}

@if(finest)
fn store_result(pixel: vec2<i32>, left: Column, center: Column, right: Column) {
    let at = tile.origin + vec2<u32>(pixel);
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    if is_clean(vec2<u32>(pixel), u32(size().x)) {
        store_noisy(at);
        return;
    }
    store_linear(at, result(pixel, left, center, right).rgb);
}
@else
fn store_result(pixel: vec2<i32>, left: Column, center: Column, right: Column) {
    // Stores outside the level do nothing.
    textureStore(output, pixel, 0, result(pixel, left, center, right));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = vec2<i32>(vec2(4u * id.x, id.y));
    if any(first >= size()) {
        return;
    }
    let before = column(first - vec2(1, 0));
    let a = column(first);
    let b = column(first + vec2(1, 0));
    let c = column(first + vec2(2, 0));
    let d = column(first + vec2(3, 0));
    let behind = column(first + vec2(4, 0));
    store_result(first, before, a, b);
    store_result(first + vec2(1, 0), a, b, c);
    store_result(first + vec2(2, 0), b, c, d);
    store_result(first + vec2(3, 0), c, d, behind);
}
