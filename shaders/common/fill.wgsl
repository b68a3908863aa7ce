// Images without bad pixels. A pixel that is not finite in every channel becomes the mean of the
// finite ones among the eight around it, or, if all of those are bad, among the 24 around it, or black.

import package::common::images::load;
import package::common::light::{MOST, is_finite, lit, luminance};
import package::common::tile::tile;

// The finite pixels around a pixel as sums and, in w, counts; and the most light among the eight.
struct Around {
    near: vec4<f32>,         // the eight nearest
    wide: vec4<f32>,         // the 24 nearest
    brightest: f32,
}

const REPAIR = 2u;           // how many pixels around a pixel are looked at
const SQUARE = 2u * REPAIR + 1u;
// Steps over the whole square. CPU drivers take all branches for all pixels, but leave loops
// without a step early: so what is rarely needed is a loop of none or AROUND steps.
const AROUND = SQUARE * SQUARE;

fn around(image: u32, at: vec2<u32>, steps: u32) -> Around {
    var found = Around();
    for (var i = 0u; i < steps; i++) {
        // Beyond the left and the upper border this wraps round to more than any size.
        let there = at + vec2(i % SQUARE, i / SQUARE) - REPAIR;
        if all(there < tile.image_size) && any(there != at) {
            let bits = load(image, there);
            if is_finite(bits) {
                let value = clamp(bitcast<vec3<f32>>(bits), vec3(-MOST), vec3(MOST));
                let is_near = all(there + 1u >= at) && all(there <= at + 1u);
                found.wide += vec4(value, 1.0);
                found.near += select(vec4<f32>(), vec4(value, 1.0), is_near);
                let light = luminance(lit(bitcast<vec3<f32>>(bits)));
                found.brightest = max(found.brightest, select(0.0, light, is_near));
            }
        }
    }
    return found;
}

fn mean(found: Around) -> vec3<f32> {
    let sum = select(found.near, found.wide, found.near.w == 0.0);
    return sum.xyz / max(sum.w, 1.0);
}

fn filled(image: u32, at: vec2<u32>) -> vec3<f32> {
    let bits = load(image, at);
    let near = around(image, at, select(AROUND, 0u, is_finite(bits)));
    return select(mean(near), bitcast<vec3<f32>>(bits), is_finite(bits));
}
