// The color as the network sees it: bad pixels filled, nothing negative or above MOST, and no
// outliers. A pixel may be OUTLIER times as bright as the brightest of the eight around it, or as
// middle gray, whichever is more. Brighter pixels are darkened to that limit and keep their hue. So
// a firefly cannot spread, while anything as bright as its neighbors, such as a lamp or a
// highlight, stays.

import package::common::fill::{AROUND, around, mean};
import package::common::images::{COLOR, load};
import package::common::light::{GREY, OUTLIER, is_finite, lit, luminance};
import package::common::scale::input_scale;

fn repaired(at: vec2<u32>) -> vec3<f32> {
    let bits = load(COLOR, at);
    let gray = GREY / input_scale;
    let is_bright = luminance(lit(bitcast<vec3<f32>>(bits))) > OUTLIER * gray;
    let near = around(COLOR, at, select(0u, AROUND, is_bright || !is_finite(bits)));
    let rgb = lit(select(mean(near), bitcast<vec3<f32>>(bits), is_finite(bits)));
    let light = luminance(rgb);
    let most = OUTLIER * max(gray, near.brightest);
    return select(rgb, rgb / light * most, light > most);
}
