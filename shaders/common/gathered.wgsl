// The sum of 3×3 pixels, weighted by the softmax of nine logits.

import package::common::weighted::inverse;

// One pixel per tap, row by row.
struct Nine {
    a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, e: vec4<f32>,
    f: vec4<f32>, g: vec4<f32>, h: vec4<f32>, i: vec4<f32>,
}

fn largest_of(v: vec4<f32>) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

fn darkest(p: Nine) -> vec3<f32> {
    let upper = min(min(p.a.rgb, p.b.rgb), min(p.c.rgb, p.d.rgb));
    let lower = min(min(p.f.rgb, p.g.rgb), min(p.h.rgb, p.i.rgb));
    return min(min(upper, lower), p.e.rgb);
}

fn brightest_of(p: Nine) -> vec3<f32> {
    let upper = max(max(p.a.rgb, p.b.rgb), max(p.c.rgb, p.d.rgb));
    let lower = max(max(p.f.rgb, p.g.rgb), max(p.h.rgb, p.i.rgb));
    return max(max(upper, lower), p.e.rgb);
}

// `first` holds the logits of taps 0 to 3, `middle` of 4 to 7, `last` of tap 8.
fn gathered(p: Nine, first: vec4<f32>, middle: vec4<f32>, last: f32) -> vec4<f32> {
    let most = max(max(largest_of(first), largest_of(middle)), last);
    // Below −100 the odds are 0, and the difference of huge logits would be infinite.
    let odds = array(
        exp(max(first - most, vec4(-100.0))),
        exp(max(middle - most, vec4(-100.0))),
    );
    let last_odds = exp(max(last - most, -100.0));
    let weights = array(
        odds[0] * vec4(p.a.w, p.b.w, p.c.w, p.d.w),
        odds[1] * vec4(p.e.w, p.f.w, p.g.w, p.h.w),
    );
    let last_weight = last_odds * p.i.w;
    let sum = dot(weights[0] + weights[1], vec4(1.0)) + last_weight;
    let total_odds = dot(odds[0] + odds[1], vec4(1.0)) + last_odds;
    let scale = inverse(sum);
    let color = mat4x3(p.a.rgb, p.b.rgb, p.c.rgb, p.d.rgb) * (weights[0] * scale)
        + mat4x3(p.e.rgb, p.f.rgb, p.g.rgb, p.h.rgb) * (weights[1] * scale)
        + p.i.rgb * (last_weight * scale);
    return vec4(clamp(color, darkest(p), brightest_of(p)), sum / total_odds);
}
