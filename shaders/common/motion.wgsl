// Where each pixel's surface was in the last frame, relative to the pixel; stored like the color.

import package::common::layout::{Layout, element_of};
import package::common::light::INFINITE;
import package::common::tile::tile;
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

// Where the surface was in the last frame, from the center of the first pixel; z is 1 if that is in
// the image, whose border is half a pixel outside the outermost centers, else 0.
fn last_place(at: vec2<u32>) -> vec3<f32> {
    let bits = load_motion(tile.motion, at);
    let is_number = all((bits & vec2(INFINITE)) != vec2(INFINITE));
    let motion = bitcast<vec2<f32>>(select(vec2(0u), bits, is_number));
    let place = vec2<f32>(at) + motion;
    let is_inside = all(place >= vec2(-0.5)) && all(place <= vec2<f32>(tile.image_size) - 0.5);
    return select(vec3(0.0), vec3(place, 1.0), is_number && is_inside);
}
