// Where each pixel's surface was in the last frame, relative to the pixel; stored like the color.

import package::common::layout::{Layout, element_of};
@if(motion_f16) import package::common::half::widened;

@if(motion_texture) @group(0) @binding(1) var motion: texture_2d<f32>;
@else @group(0) @binding(1) var<storage, read> motion: array<u32>;

@if(motion_f16)
fn motion_element(i: u32) -> u32 {
    return widened(motion[i / 2u], i);
}
@elif(!motion_texture)
fn motion_element(i: u32) -> u32 {
    return motion[i];
}

// The bits of a pixel's first two elements as 32-bit floats.
@if(motion_texture)
fn load_motion(image: Layout, at: vec2<u32>) -> vec2<u32> {
    return bitcast<vec2<u32>>(textureLoad(motion, at, 0).rg);
}
@else
fn load_motion(image: Layout, at: vec2<u32>) -> vec2<u32> {
    let i = element_of(image, at);
    return vec2(motion_element(i), motion_element(i + 1u));
}
