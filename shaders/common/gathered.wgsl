// The sum of 3×3 pixels, weighted by the softmax of nine logits.

import package::common::weighted::{Pixel, inverse};

// One pixel per tap, row by row.
struct Nine {
    a: Pixel, b: Pixel, c: Pixel, d: Pixel, e: Pixel, f: Pixel, g: Pixel, h: Pixel, i: Pixel,
}

// The same for one color of each pixel.
struct NineColors {
    a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>, e: vec3<f32>,
    f: vec3<f32>, g: vec3<f32>, h: vec3<f32>, i: vec3<f32>,
}

// A number per tap.
struct Taps9 {
    first: vec4<f32>, middle: vec4<f32>, last: f32,
}

fn largest_of(v: vec4<f32>) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

fn total(v: Taps9) -> f32 {
    return dot(v.first + v.middle, vec4(1.0)) + v.last;
}

fn darkest(p: NineColors) -> vec3<f32> {
    return min(min(min(min(p.a, p.b), min(p.c, p.d)), min(min(p.f, p.g), min(p.h, p.i))), p.e);
}

fn brightest_of(p: NineColors) -> vec3<f32> {
    return max(max(max(max(p.a, p.b), max(p.c, p.d)), max(max(p.f, p.g), max(p.h, p.i))), p.e);
}

// The exponentials of the logits, relative to the largest.
fn odds_of(logits: Taps9) -> Taps9 {
    let most = max(max(largest_of(logits.first), largest_of(logits.middle)), logits.last);
    // Below −100 the odds are 0, and the difference of huge logits would be infinite.
    return Taps9(
        exp(max(logits.first - most, vec4(-100.0))),
        exp(max(logits.middle - most, vec4(-100.0))),
        exp(max(logits.last - most, -100.0)),
    );
}

fn mean_of_nine(p: NineColors, shares: Taps9) -> vec3<f32> {
    let mean = mat4x3(p.a, p.b, p.c, p.d) * shares.first
        + mat4x3(p.e, p.f, p.g, p.h) * shares.middle
        + p.i * shares.last;
    return clamp(mean, darkest(p), brightest_of(p));
}

fn gathered(p: Nine, logits: Taps9) -> Pixel {
    let odds = odds_of(logits);
    let weights = Taps9(
        odds.first * vec4(p.a.weight, p.b.weight, p.c.weight, p.d.weight),
        odds.middle * vec4(p.e.weight, p.f.weight, p.g.weight, p.h.weight),
        odds.last * p.i.weight,
    );
    let sum = total(weights);
    let scale = inverse(sum);
    let shares = Taps9(weights.first * scale, weights.middle * scale, weights.last * scale);
    let colors = NineColors(
        p.a.color, p.b.color, p.c.color, p.d.color, p.e.color,
        p.f.color, p.g.color, p.h.color, p.i.color,
    );
    @if(demodulates)
    let albedos = NineColors(
        p.a.albedo, p.b.albedo, p.c.albedo, p.d.albedo, p.e.albedo,
        p.f.albedo, p.g.albedo, p.h.albedo, p.i.albedo,
    );
    @if(demodulates)
    let albedo = mean_of_nine(albedos, shares);
    @else
    let albedo = vec3<f32>();
    return Pixel(mean_of_nine(colors, shares), sum / total(odds), albedo);
}
