// Fills bad pixels. A pixel that is not finite in every channel becomes the mean of the finite ones
// among the eight around it, or, if all of those are bad, among the 24 around it, or else black.

import package::common::images::load;
import package::common::light::{INFINITE, MOST, is_finite, lit, luminance, with_infinity};
import package::common::tile::tile;

// The finite pixels around a pixel, as sums with counts in w, and the brightest light among the
// eight.
struct Around {
    near: vec4<f32>,         // the eight nearest
    wide: vec4<f32>,         // the 24 nearest
    brightest: f32,
}

const REPAIR = 2u;           // how far around a pixel to look
const SQUARE = 2u * REPAIR + 1u;
// Steps over the whole square. CPU drivers take all branches for all pixels but leave a loop
// without steps early, so rarely needed work is a loop of either 0 or AROUND steps.
const AROUND = SQUARE * SQUARE;

// Beyond the left and top borders, this wraps around to values larger than any image.
fn place_around(at: vec2<u32>, i: u32) -> vec2<u32> {
    return at + vec2(i % SQUARE, i / SQUARE) - REPAIR;
}

// `infinite` has the bits that +∞ stands for; with INFINITE it stays as bad as NaN.
fn around(image: u32, at: vec2<u32>, infinite: u32, steps: u32) -> Around {
    var found = Around();
    for (var i = 0u; i < steps; i++) {
        let there = place_around(at, i);
        if all(there < tile.image_size) && any(there != at) {
            let bits = with_infinity(load(image, there), infinite);
            if is_finite(bits) {
                let value = clamp(bitcast<vec3<f32>>(bits), vec3(-MOST), vec3(MOST));
                let is_near = all(there + 1u >= at) && all(there <= at + 1u);
                found.wide += vec4(value, 1.0);
                found.near += select(vec4<f32>(), vec4(value, 1.0), is_near);
                let light = luminance(lit(value));
                found.brightest = max(found.brightest, select(0.0, light, is_near));
            }
        }
    }
    return found;
}

// w is 0 if there is nothing to average, else 1.
fn mean(found: Around) -> vec4<f32> {
    let sum = select(found.near, found.wide, found.near.w == 0.0);
    return sum / max(sum.w, 1.0);
}

// w is as in `mean`.
fn filled(image: u32, at: vec2<u32>) -> vec4<f32> {
    let bits = load(image, at);
    let near = around(image, at, INFINITE, select(AROUND, 0u, is_finite(bits)));
    return select(mean(near), vec4(bitcast<vec3<f32>>(bits), 1.0), is_finite(bits));
}
