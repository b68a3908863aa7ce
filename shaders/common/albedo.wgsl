// The albedo, stored like the color.

import package::common::layout::{Layout, element_of};
@if(albedo_f16) import package::common::half::widened;

@if(gather) const ALBEDO_BINDING = 8;
@elif(finest) const ALBEDO_BINDING = 6;
@elif(accumulate || level0) const ALBEDO_BINDING = 5;
@else const ALBEDO_BINDING = 2;

@if(albedo_texture) @group(0) @binding(ALBEDO_BINDING) var albedo: texture_2d<f32>;
@else @group(0) @binding(ALBEDO_BINDING) var<storage, read> albedo: array<u32>;

@if(albedo_f16)
fn albedo_element(i: u32) -> u32 {
    return widened(albedo[i / 2u], i);
}
@elif(!albedo_texture)
fn albedo_element(i: u32) -> u32 {
    return albedo[i];
}

// The bits of a pixel's first three elements as 32-bit floats.
@if(albedo_texture)
fn load_albedo(image: Layout, at: vec2<u32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(textureLoad(albedo, at, 0).rgb);
}
@else
fn load_albedo(image: Layout, at: vec2<u32>) -> vec3<u32> {
    let i = element_of(image, at);
    return vec3(albedo_element(i), albedo_element(i + 1u), albedo_element(i + 2u));
}
