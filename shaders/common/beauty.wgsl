// The color that the network reads, for kernels that filter a further layer of the image with the
// same weights. Stored like the color.

import package::common::layout::{Layout, element_of};
@if(beauty_f16) import package::common::half::widened;

@if(beauty_texture) @group(0) @binding(5) var beauty: texture_2d<f32>;
@else @group(0) @binding(5) var<storage, read> beauty: array<u32>;

@if(beauty_f16)
fn beauty_element(i: u32) -> u32 {
    return widened(beauty[i / 2u], i);
}
@elif(!beauty_texture)
fn beauty_element(i: u32) -> u32 {
    return beauty[i];
}

// The bits of a pixel's first three elements as 32-bit floats.
@if(beauty_texture)
fn load_beauty(image: Layout, at: vec2<u32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(textureLoad(beauty, at, 0).rgb);
}
@else
fn load_beauty(image: Layout, at: vec2<u32>) -> vec3<u32> {
    let i = element_of(image, at);
    return vec3(beauty_element(i), beauty_element(i + 1u), beauty_element(i + 2u));
}
