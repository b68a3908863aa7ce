// The image `color` as the network is to see it: bad pixels filled, nothing negative or above MOST,
// and no outliers. A pixel may be OUTLIER times as bright as the brightest of the eight around it, or as
// middle grey, whichever is more; above that, it is darkened to it and keeps its hue. So a firefly
// cannot spread, and what is as bright as its neighbours, such as a lamp or a highlight, stays.

const GREY = 0.18;           // what the average luminance becomes, times input_scale
const OUTLIER = 16.0;

fn repaired_color(at: vec2<u32>) -> vec3<f32> {
    let bits = load_color(at);
    let grey = GREY / input_scale;
    let is_bright = luminance(lit(bitcast<vec3<f32>>(bits))) > OUTLIER * grey;
    let around = around_in_color(at, select(0u, AROUND, is_bright || !is_finite(bits)));
    let rgb = lit(select(mean(around), bitcast<vec3<f32>>(bits), is_finite(bits)));
    let light = luminance(rgb);
    let most = OUTLIER * max(grey, around.brightest);
    return select(rgb, rgb / light * most, light > most);
}

