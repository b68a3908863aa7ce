// A further layer of the image, repaired where its beauty is: pixels that are missing in either are
// filled, and the repair scales every layer by the same factor as the beauty. So layers that add up
// to the beauty still do.

import package::common::fill::{AROUND, around, mean};
import package::common::images::{COLOR, LAYER, load};
import package::common::light::{MOST, is_finite, with_infinity};
import package::common::repair::{infinite_of, repaired};

// Linear color, with the beauty's w.
fn repaired_layer(at: vec2<u32>) -> vec4<f32> {
    let found = load(COLOR, at);
    let infinite = infinite_of(at, found);
    let beauty = with_infinity(found, infinite);
    let own = with_infinity(load(LAYER, at), infinite);
    let is_whole = is_finite(beauty) && is_finite(own);
    let near = around(LAYER, at, infinite, select(AROUND, 0u, is_whole));
    let value = select(mean(near).rgb, bitcast<vec3<f32>>(own), is_whole);
    return vec4(clamp(value, vec3(-MOST), vec3(MOST)), 1.0) * change(beauty, repaired(at));
}

// The factors by which the repair changes a pixel; 1 where it fills the pixel.
fn change(beauty: vec3<u32>, repaired: vec4<f32>) -> vec4<f32> {
    let before = bitcast<vec3<f32>>(beauty);
    let is_changed = vec3(is_finite(beauty)) & (repaired.rgb != before) & (before != vec3(0.0));
    return vec4(select(vec3(1.0), repaired.rgb / before, is_changed), repaired.w);
}
