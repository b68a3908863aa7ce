// The color as the network sees it. Pixels with NaN or −∞ are missing and filled, and so are those
// with +∞, unless at least SUN of the 3×3 pixels have it. Then it is very bright light: the largest
// 16-bit float, or the largest value around if that is more. Negative channels stay, as wide gamuts
// need them, unless the pixel's luminance is negative too. A pixel may be `outlier` times as bright
// as the brightest of the eight around it, or as middle gray, whichever is more. Brighter pixels
// are darkened to that limit and keep their hue. So a firefly cannot spread, while anything as
// bright as its neighbors, such as a lamp or a highlight, stays.

import package::common::encoding::{SIGNED, transfer_function};
import package::common::fill::{AROUND, around, filled, mean, place_around};
import package::common::images::{COLOR, load};
import package::common::light::{
    GREY, INFINITE, MOST, is_finite, lit, luminance, with_infinity
};
import package::common::limits::LARGEST_F16;
import package::common::scale::input_scale;
import package::common::tile::tile;

override outlier: f32;       // how many times brighter than its surroundings a pixel may be

const SUN = 4u;              // fewer infinite pixels together are fireflies

// The bits that +∞ stands for at a pixel; with INFINITE it stays as bad as NaN.
fn infinite_at(at: vec2<u32>, steps: u32) -> u32 {
    var most = LARGEST_F16;
    var count = 0u;
    for (var i = 0u; i < steps; i++) {
        let there = place_around(at, i);
        if all(there < tile.image_size) {
            let bits = load(COLOR, there);
            let is_near = all(there + 1u >= at) && all(there <= at + 1u);
            count += u32(is_near && any(bits == vec3(INFINITE)));
            let is_number = (bits & vec3(INFINITE)) != vec3(INFINITE);
            let values = bitcast<vec3<f32>>(select(vec3(0u), bits, is_number));
            most = max(most, max(values.r, max(values.g, values.b)));
        }
    }
    return select(INFINITE, bitcast<u32>(most), count >= SUN);
}

// `infinite_at` where it matters: if the pixel is not finite, or bright enough to be an outlier.
fn infinite_of(at: vec2<u32>, found: vec3<u32>) -> u32 {
    return infinite_at(at, steps_around(found));
}

fn steps_around(found: vec3<u32>) -> u32 {
    let is_bright = luminance(lit(bitcast<vec3<f32>>(found))) > outlier * (GREY / input_scale);
    return select(0u, AROUND, is_bright || !is_finite(found));
}

// Linear color, with 1 in w. Where a missing pixel cannot be filled, everything is 0.
fn repaired(at: vec2<u32>) -> vec4<f32> {
    // Signed data is not light.
    if transfer_function == SIGNED {
        return filled(COLOR, at);
    }
    let found = load(COLOR, at);
    let infinite = infinite_of(at, found);
    let near = around(COLOR, at, infinite, steps_around(found));
    let bits = with_infinity(found, infinite);
    let whole = select(mean(near), vec4(bitcast<vec3<f32>>(bits), 1.0), is_finite(bits));
    return vec4(darkened(whole.rgb, outlier * max(GREY / input_scale, near.brightest)), whole.w);
}

// Sets negative channels to 0 if the luminance is negative, and limits the luminance to `most`.
fn darkened(rgb: vec3<f32>, most: f32) -> vec3<f32> {
    let lowest = select(-MOST, 0.0, luminance(rgb) < 0.0);
    let number = clamp(rgb, vec3(lowest), vec3(MOST));
    let light = luminance(lit(number));
    return select(number, number / light * most, light > most);
}
