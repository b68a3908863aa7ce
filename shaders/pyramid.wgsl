// One level of a kernel pyramid: the mean of 2×2 pixels of the finer level, times the level's
// confidence. One pixel per invocation. Level 0 is the noisy color with its confidence, and the
// albedo. On GPUs it is not stored, and level 1 computes what it needs from it.

import package::common::tensor::TensorIn;
import package::common::weighted::{
    LAST_QUAD, LightIn, LightOut, Pixel, color_layer, confidence, pixel_of, sum_of_four,
};
@if(demodulates) import package::common::weighted::albedo_layer;
@if(level0 || finest) import package::common::finest::finest;

@if(finest) @group(0) @binding(2) var logits: TensorIn;
@elif(!level0) @group(0) @binding(1) var logits: TensorIn;

@if(level0 || finest) @group(0) @binding(3) var output: LightOut;
@else @group(0) @binding(2) var output: LightOut;

@if(!level0 && !finest) @group(0) @binding(0) var input: LightIn;

@if(finest)
fn finer(pixel: vec2<u32>) -> Pixel {
    return finest(pixel);
}
@elif(demodulates && !level0)
fn finer(pixel: vec2<u32>) -> Pixel {
    return pixel_of(textureLoad(input, pixel, 0), textureLoad(input, pixel, 1));
}
@elif(!level0)
fn finer(pixel: vec2<u32>) -> Pixel {
    return pixel_of(textureLoad(input, pixel, 0));
}

@if(level0)
fn level(pixel: vec2<u32>) -> Pixel {
    return finest(pixel);
}
@else
fn level(pixel: vec2<u32>) -> Pixel {
    let corner = pixel * 2u;
    let sum = sum_of_four(
        finer(corner),
        finer(corner + vec2(1u, 0u)),
        finer(corner + vec2(0u, 1u)),
        finer(corner + vec2(1u, 1u)),
        vec4(0.25),
    );
    let confidence_here = confidence(textureLoad(logits, pixel, LAST_QUAD));
    return Pixel(sum.color, sum.weight * confidence_here, sum.albedo);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(output)) {
        return;
    }
    let pixel = level(id.xy);
    textureStore(output, id.xy, 0, color_layer(pixel));
    @if(demodulates)
    textureStore(output, id.xy, 1, albedo_layer(pixel));
}
