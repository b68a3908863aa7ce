// The finest level of a kernel pyramid: the noisy color, or the albedo, with its confidence as the
// weight, 0 where the color is missing. Kernels for CPU drivers read it from memory; those for
// GPUs, where memory is slower than arithmetic, compute it from the noisy color wherever it is
// needed. The albedo's is always stored.

import package::common::tensor::TensorIn;
@if(stored_finest) import package::common::weighted::LightIn;
@else import package::common::place::place;
@if(!stored_finest && layer) import package::common::layer::repaired_layer;
@if(!stored_finest && !layer) import package::common::repair::repaired;
@if(of_albedo) import package::common::reflectance::reflectance;
@if(!stored_finest) import package::common::weighted::{LAST_QUAD, confidence};

@if(gather) @group(0) @binding(6) var finest_logits: TensorIn;
@elif(level0) @group(0) @binding(2) var finest_logits: TensorIn;
@else @group(0) @binding(5) var finest_logits: TensorIn;

@if(stored_finest) @group(0) @binding(8) var stored_light: LightIn;

@if(stored_finest)
fn finest(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(stored_light, pixel, 0);
}
@else
fn finest(pixel: vec2<u32>) -> vec4<f32> {
    @if(layer)
    let color = repaired_layer(place(pixel));
    @else
    let color = repaired(place(pixel));
    let logits = textureLoad(finest_logits, pixel, LAST_QUAD);
    @if(of_albedo)
    return vec4(reflectance(place(pixel)), color.w * confidence(logits));
    @else
    return vec4(color.rgb, color.w * confidence(logits));
}
