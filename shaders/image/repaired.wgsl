// The image `color` as the network is to see it: bad pixels filled, nothing negative, and no
// outliers. A pixel may be OUTLIER times as bright as the brightest of the eight around it, or as
// middle grey, whichever is more; above that, it is darkened to it and keeps its hue. So a firefly
// cannot spread, and what is as bright as its neighbours, such as a lamp or a highlight, stays.

const GREY = 0.18;           // what the average luminance becomes, times input_scale
const OUTLIER = 16.0;

fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3(0.212671, 0.715160, 0.072169));
}

fn repaired_color(at: vec2<u32>) -> vec3<f32> {
    let rgb = max(filled_color(at), vec3(0.0));
    let bright = luminance(rgb);
    let grey = GREY / input_scale;
    // Nearly all pixels end here: neighbours are not read for nothing.
    if bright <= OUTLIER * grey {
        return rgb;
    }
    let most = OUTLIER * max(grey, brightest_around(at));
    return select(rgb, rgb / bright * most, bright > most);
}

fn brightest_around(at: vec2<u32>) -> f32 {
    let begin = max(at, vec2(1u)) - 1u;
    let end = min(at + 2u, tile.image_size);
    var brightest = 0.0;
    for (var y = begin.y; y < end.y; y++) {
        for (var x = begin.x; x < end.x; x++) {
            let bits = load_color(vec2(x, y));
            if is_finite_in_color(bits) && any(vec2(x, y) != at) {
                brightest = max(brightest, luminance(max(bitcast<vec3<f32>>(bits), vec3(0.0))));
            }
        }
    }
    return brightest;
}

