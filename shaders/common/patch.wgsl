// The history between its pixels: the 4×4 around a place, without those that have none. Beyond the
// picture, its edge repeats.

import package::common::history::{kept_albedo, kept_color, kept_depth, kept_normal};
import package::common::inputs::{has_albedo, has_normal};
import package::common::light::MOST;
import package::common::seen::{Seen, exposed, has_depth};
import package::common::tile::tile;

struct Past {
    color: vec3<f32>,
    count: f32,              // of frames; 0 if there is no history, and then nothing else counts
    seen: Seen,
}

struct Sums {
    spline: vec3<f32>,       // color by Catmull-Rom splines
    linear: vec4<f32>,       // color by bilinear shares, and in w their sum
    light: vec4<f32>,        // what `Seen` has, and in w the sum of the shares
    count: f32,
    least: vec3<f32>,        // of the four nearest pixels
    most: vec3<f32>,
    is_whole: bool,          // all of them have a history
}

fn spline_weights(t: f32) -> vec4<f32> {
    return vec4(
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    );
}

fn linear_weights(t: f32) -> vec4<f32> {
    return vec4(0.0, 1.0 - t, t, 0.0);
}

// Of means of three pixels that are read bilinearly.
fn wide_weights(t: f32) -> vec4<f32> {
    return vec4(1.0 - t, 1.0, 1.0, t) / 3.0;
}

// Pixel (1, 1) is the nearest one to the left and above.
fn pixel_at(place: vec2<f32>, step: vec2<u32>) -> vec2<u32> {
    let at = vec2<i32>(floor(place)) + vec2<i32>(step) - 1;
    return vec2<u32>(clamp(at, vec2(0), vec2<i32>(tile.image_size) - 1));
}

fn sums_around(place: vec2<f32>) -> Sums {
    let t = place - floor(place);
    let spline = array(spline_weights(t.x), spline_weights(t.y));
    let linear = array(linear_weights(t.x), linear_weights(t.y));
    let wide = array(wide_weights(t.x), wide_weights(t.y));
    var sums = Sums(vec3(0.0), vec4(0.0), vec4(0.0), 0.0, vec3(MOST), vec3(-MOST), true);
    for (var i = 0u; i < 16u; i++) {
        let step = vec2(i % 4u, i / 4u);
        let kept = kept_color(pixel_at(place, step));
        let has_history = kept.w > 0.0;
        let valid = select(0.0, 1.0, has_history);
        let share = linear[0][step.x] * linear[1][step.y];
        sums.spline += spline[0][step.x] * spline[1][step.y] * kept.rgb;
        sums.linear += valid * share * vec4(kept.rgb, 1.0);
        sums.light += valid * wide[0][step.x] * wide[1][step.y] * vec4(exposed(kept.rgb), 1.0);
        sums.count += share * kept.w;
        let is_near = has_history && all(step - 1u < vec2(2u));
        sums.least = select(sums.least, min(sums.least, kept.rgb), is_near);
        sums.most = select(sums.most, max(sums.most, kept.rgb), is_near);
        sums.is_whole &= has_history;
    }
    return sums;
}

// The bilinear mean, sharpened towards the spline as far as all channels stay in the range of the
// four nearest pixels.
fn sharpened(sums: Sums) -> vec3<f32> {
    let linear = clamp(sums.linear.rgb / sums.linear.w, sums.least, sums.most);
    let change = sums.spline - linear;
    let room = select(linear - sums.least, sums.most - linear, change > vec3(0.0));
    let shares = select(vec3(1.0), room / abs(change), abs(change) > room);
    let share = select(0.0, min(shares.x, min(shares.y, shares.z)), sums.is_whole);
    return clamp(linear + share * change, sums.least, sums.most);
}

// Bilinear means of what else is kept.
fn features_around(place: vec2<f32>) -> Seen {
    let t = place - floor(place);
    var sum = Seen();
    var total = 0.0;
    var hits = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2(i % 2u, i / 2u);
        let at = pixel_at(place, step + 1u);
        let shares = select(1.0 - t, t, step == vec2(1u));
        let share = select(0.0, shares.x * shares.y, kept_color(at).w > 0.0);
        total += share;
        if has_albedo {
            sum.albedo += share * kept_albedo(at);
        }
        if has_normal {
            sum.normal += share * kept_normal(at);
        }
        if has_depth {
            sum.depth += share * kept_depth(at);
            hits += select(0.0, share, kept_depth(at) > 0.0);
        }
    }
    let depth = select(0.0, sum.depth / hits, hits > 0.0);
    return Seen(vec3(0.0), sum.albedo / total, sum.normal / total, depth);
}

fn past_at(place: vec2<f32>) -> Past {
    let sums = sums_around(place);
    var seen = features_around(place);
    seen.light = sums.light.rgb / sums.light.w;
    return Past(sharpened(sums), select(0.0, sums.count, sums.linear.w > 0.0), seen);
}
