// The noisy color: 32-bit floats in a buffer, 16-bit floats in a buffer, or a texture.

import package::common::layout::{Layout, element_of};
@if(color_f16) import package::common::half::widened;

@if(color_texture) @group(0) @binding(1) var color: texture_2d<f32>;
@else @group(0) @binding(1) var<storage, read> color: array<u32>;

@if(color_f16)
fn color_element(i: u32) -> u32 {
    return widened(color[i / 2u], i);
}
@elif(!color_texture)
fn color_element(i: u32) -> u32 {
    return color[i];
}

// The bits of a pixel's first three elements as 32-bit floats, so that NaN and infinity are
// recognized before any float operation sees them.
@if(color_texture)
fn load_color(image: Layout, at: vec2<u32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(textureLoad(color, at, 0).rgb);
}
@else
fn load_color(image: Layout, at: vec2<u32>) -> vec3<u32> {
    let i = element_of(image, at);
    return vec3(color_element(i), color_element(i + 1u), color_element(i + 2u));
}

// The alpha, or 1 if the image has none.
@if(color_texture)
fn alpha_of_color(image: Layout, at: vec2<u32>) -> f32 {
    return textureLoad(color, at, 0).a;
}
@else
fn alpha_of_color(image: Layout, at: vec2<u32>) -> f32 {
    if image.channels < 4u {
        return 1.0;
    }
    return bitcast<f32>(color_element(element_of(image, at) + 3u));
}
