// The finest level of a kernel pyramid: the noisy color with its confidence as the weight, 0 where
// the color is missing, and the albedo. Kernels for CPU drivers read it from memory; those for
// GPUs, where memory is slower than arithmetic, compute it from the images wherever it is needed.

import package::common::tensor::TensorIn;
@if(stored_finest) import package::common::weighted::{LightIn, Pixel, pixel_of};
@else import package::common::place::place;
@if(!stored_finest && layer) import package::common::layer::repaired_layer;
@if(!stored_finest && !layer) import package::common::repair::repaired;
@if(!stored_finest && demodulates) import package::common::reflectance::reflectance;
@if(!stored_finest) import package::common::weighted::{LAST_QUAD, Pixel, confidence};

@if(gather) @group(0) @binding(6) var finest_logits: TensorIn;
@elif(level0) @group(0) @binding(2) var finest_logits: TensorIn;
@else @group(0) @binding(5) var finest_logits: TensorIn;

@if(stored_finest) @group(0) @binding(8) var stored_light: LightIn;

@if(stored_finest && demodulates)
fn finest(pixel: vec2<u32>) -> Pixel {
    return pixel_of(textureLoad(stored_light, pixel, 0), textureLoad(stored_light, pixel, 1));
}
@elif(stored_finest)
fn finest(pixel: vec2<u32>) -> Pixel {
    return pixel_of(textureLoad(stored_light, pixel, 0));
}
@else
fn finest(pixel: vec2<u32>) -> Pixel {
    @if(layer)
    let color = repaired_layer(place(pixel));
    @else
    let color = repaired(place(pixel));
    @if(demodulates)
    let albedo = reflectance(place(pixel));
    @else
    let albedo = vec3<f32>();
    let logits = textureLoad(finest_logits, pixel, LAST_QUAD);
    return Pixel(color.rgb, color.w * confidence(logits), albedo);
}
