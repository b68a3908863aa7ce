// One level of a kernel pyramid's result: the sum of 3×3 pixels of the level, weighted by the
// softmax of its logits, plus the coarser level's result, upsampled and times the share. Four
// pixels of a row per invocation, which share what they read.
//
// At the finest level, the modulated color of the sum is the image; clean blocks keep their input.
// In them, a further layer, which need not be clean itself, keeps level 0 of its pyramid.

import package::common::gathered::{Nine, Taps9, gathered};
import package::common::tensor::TensorIn;
import package::common::weighted::{
    LAST_QUAD, LightIn, Pixel, pixel_of, share, sum_of_four, sum_of_two,
};
@if(finest) import package::common::clean::is_clean;
@if(finest && layer) import package::common::color::load_color;
@if(finest) import package::common::demodulation::modulated;
@if(finest) import package::common::finest::finest_logits;
@if(stored_finest) import package::common::finest::finest;
@if(finest && layer) import package::common::light::{MOST, is_finite};
@if(finest) import package::common::result::store_linear;
@if(finest && !layer) import package::common::result::store_noisy;
@if(finest && !stored_finest) import package::common::staged_light::{stage, staged};
@if(finest) import package::common::tile::tile;
@if(!finest) import package::common::weighted::{LightOut, color_layer};
@if(!finest && demodulates) import package::common::weighted::albedo_layer;

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

// A pixel of the level. Beyond the edge, pixels repeat.
@if(finest && !stored_finest)
fn at_level(pixel: vec2<i32>) -> Pixel {
    return staged(pixel);
}
@else
fn at_level(pixel: vec2<i32>) -> Pixel {
    let at = vec2<u32>(clamp(pixel, vec2(0), size() - 1));
    @if(finest)
    return finest(at);
    @elif(demodulates)
    return pixel_of(textureLoad(input, at, 0), textureLoad(input, at, 1));
    @else
    return pixel_of(textureLoad(input, at, 0));
}

@if(!bottom && demodulates)
fn coarser_at(pixel: vec2<i32>) -> Pixel {
    return pixel_of(textureLoad(coarser, pixel, 0), textureLoad(coarser, pixel, 1));
}
@elif(!bottom)
fn coarser_at(pixel: vec2<i32>) -> Pixel {
    return pixel_of(textureLoad(coarser, pixel, 0));
}

// A coarser pixel and the one above or below it, whichever is nearer to row `y` of this level.
struct Pair {
    near: Pixel, far: Pixel,
}

@if(bottom)
fn pair(x: i32, y: i32) -> Pair {
    return Pair();
}
@else
fn pair(x: i32, y: i32) -> Pair {
    let most = size() / 2 - 1;
    let column = clamp(x, 0, most.x);
    let next = clamp(y / 2 + 2 * (y & 1) - 1, 0, most.y);
    return Pair(
        coarser_at(vec2(column, y / 2)),
        coarser_at(vec2(column, next)),
    );
}

// A pixel and those above and below it.
struct Column {
    above: Pixel, middle: Pixel, below: Pixel,
}

fn column(pixel: vec2<i32>) -> Column {
    return Column(at_level(pixel - vec2(0, 1)), at_level(pixel), at_level(pixel + vec2(0, 1)));
}

fn gathered_at(pixel: vec2<i32>, left: Column, center: Column, right: Column) -> Pixel {
    let pixels = Nine(
        left.above, center.above, right.above,
        left.middle, center.middle, right.middle,
        left.below, center.below, right.below,
    );
    let last = load_logits(pixel, LAST_QUAD).x;
    return gathered(pixels, Taps9(load_logits(pixel, 0u), load_logits(pixel, 1u), last));
}

// Adds the coarser level, bilinearly: of its four nearest pixels, the nearest counts 3/4 along each
// axis.
@if(bottom)
fn with_coarser(pixel: vec2<i32>, own: Pixel, near: Pair, far: Pair) -> Pixel {
    return own;
}
@else
fn with_coarser(pixel: vec2<i32>, own: Pixel, near: Pair, far: Pair) -> Pixel {
    let factors = vec4(9.0, 3.0, 3.0, 1.0) / 16.0;
    let sum = sum_of_four(near.near, far.near, near.far, far.far, factors);
    return sum_of_two(own, sum, share(load_logits(pixel, LAST_QUAD)));
}

// A layer's pixel in a clean block. There, the repair at most fills values that are not finite and
// sets negative light to 0. All other values keep their bits.
@if(finest && layer)
fn kept(at: vec2<u32>, repaired: vec3<f32>) -> vec3<f32> {
    let bits = load_color(tile.color, at);
    let own = clamp(bitcast<vec3<f32>>(bits), vec3(-MOST), vec3(MOST));
    return select(repaired, own, vec3(is_finite(bits)) & (repaired != vec3(0.0)));
}

// `own` is the pixel's albedo.
@if(finest)
fn store_result(pixel: vec2<i32>, own: vec3<f32>, sum: Pixel) {
    let at = tile.origin + vec2<u32>(pixel);
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    let here = vec2<u32>(pixel);
    if is_clean(here, u32(size().x)) {
        @if(layer)
        store_linear(at, kept(at, finest(here).color));
        @else
        store_noisy(at);
        return;
    }
    let color = modulated(sum, own, load_logits(pixel, LAST_QUAD));
    // A sum without weight has no color; what it holds is its darkest pixel.
    store_linear(at, select(vec3(0.0), color, sum.weight > 0.0));
}
@else
fn store_result(pixel: vec2<i32>, own: vec3<f32>, sum: Pixel) {
    // Stores outside the level do nothing.
    textureStore(output, pixel, 0, color_layer(sum));
    @if(demodulates)
    textureStore(output, pixel, 1, albedo_layer(sum));
}

// Stores the two pixels over one coarser pixel, `middle`. The columns `a` to `d` reach from the
// left of the first to the right of the second.
fn store_two(
    first: vec2<i32>,
    a: Column, b: Column, c: Column, d: Column,
    left: Pair, middle: Pair, right: Pair,
) {
    let second = first + vec2(1, 0);
    let own_first = gathered_at(first, a, b, c);
    let own_second = gathered_at(second, b, c, d);
    store_result(first, b.middle.albedo, with_coarser(first, own_first, middle, left));
    store_result(second, c.middle.albedo, with_coarser(second, own_second, middle, right));
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    @if(finest && !stored_finest)
    stage(vec2<i32>(group.xy), invocation, size());
    let first = vec2<i32>(vec2(4u * id.x, id.y));
    if any(first >= size()) {
        return;
    }
    let third = first + vec2(2, 0);
    let a = column(first - vec2(1, 0));
    let b = column(first);
    let c = column(first + vec2(1, 0));
    let d = column(third);
    let e = column(third + vec2(1, 0));
    let f = column(third + vec2(2, 0));
    let left = pair(first.x / 2 - 1, first.y);
    let middle_left = pair(first.x / 2, first.y);
    let middle_right = pair(third.x / 2, first.y);
    let right = pair(third.x / 2 + 1, first.y);
    store_two(first, a, b, c, d, left, middle_left, middle_right);
    store_two(third, c, d, e, f, middle_left, middle_right, right);
}
