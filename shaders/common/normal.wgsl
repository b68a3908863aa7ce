// The normal, stored like the color.

import package::common::layout::{Layout, element_of};
@if(normal_f16) import package::common::half::widened;

@if(normal_texture) @group(0) @binding(3) var normal: texture_2d<f32>;
@else @group(0) @binding(3) var<storage, read> normal: array<u32>;

@if(normal_f16)
fn normal_element(i: u32) -> u32 {
    return widened(normal[i / 2u], i);
}
@elif(!normal_texture)
fn normal_element(i: u32) -> u32 {
    return normal[i];
}

// The bits of a pixel's first three elements as 32-bit floats.
@if(normal_texture)
fn load_normal(image: Layout, at: vec2<u32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(textureLoad(normal, at, 0).rgb);
}
@else
fn load_normal(image: Layout, at: vec2<u32>) -> vec3<u32> {
    let i = element_of(image, at);
    return vec3(normal_element(i), normal_element(i + 1u), normal_element(i + 2u));
}
