// The history between its pixels.

import package::common::history::{kept_albedo, kept_color, kept_depth, kept_normal};
import package::common::inputs::{has_albedo, has_normal};
import package::common::seen::{Seen, exposed, has_depth};
import package::common::spline::{
    Reading, linear_share, nothing_read, pixel_at, weights_at, with_pixel,
};

struct Past {
    color: Reading,
    count: f32,              // of frames; 0 if there is no history, and then nothing else counts
    seen: Seen,
}

struct Sums {
    color: Reading,
    light: vec4<f32>,        // as in `Seen`, with the sum of the shares in w
    count: f32,
}

// The weights of means of three pixels that are read bilinearly.
fn wide_weights(t: f32) -> vec4<f32> {
    return vec4(1.0 - t, 1.0, 1.0, t) / 3.0;
}

fn sums_around(place: vec2<f32>) -> Sums {
    let t = place - floor(place);
    let wide = array(wide_weights(t.x), wide_weights(t.y));
    let weights = weights_at(place);
    var sums = Sums(nothing_read(), vec4(0.0), 0.0);
    for (var i = 0u; i < 16u; i++) {
        let step = vec2(i % 4u, i / 4u);
        let kept = kept_color(pixel_at(place, step));
        let valid = select(0.0, 1.0, kept.w > 0.0);
        sums.color = with_pixel(sums.color, weights, step, kept);
        sums.light += valid * wide[0][step.x] * wide[1][step.y] * vec4(exposed(kept.rgb), 1.0);
        sums.count += linear_share(weights, step) * kept.w;
    }
    return sums;
}

// Bilinear means of the features that are kept.
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
    return Past(sums.color, select(0.0, sums.count, sums.color.linear.w > 0.0), seen);
}
