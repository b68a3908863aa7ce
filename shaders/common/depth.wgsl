// The distance from the camera's plane, stored like the color.

import package::common::layout::{Layout, element_of};
@if(depth_f16) import package::common::half::widened;

@if(depth_texture) @group(0) @binding(6) var depth: texture_2d<f32>;
@else @group(0) @binding(6) var<storage, read> depth: array<u32>;

// The bits of a pixel's first element as a 32-bit float.
@if(depth_texture)
fn load_depth(image: Layout, at: vec2<u32>) -> u32 {
    return bitcast<u32>(textureLoad(depth, at, 0).r);
}
@elif(depth_f16)
fn load_depth(image: Layout, at: vec2<u32>) -> u32 {
    let i = element_of(image, at);
    return widened(depth[i / 2u], i);
}
@else
fn load_depth(image: Layout, at: vec2<u32>) -> u32 {
    return depth[element_of(image, at)];
}
