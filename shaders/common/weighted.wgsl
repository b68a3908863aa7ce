// Pixels of a kernel pyramid: a color and its weight. As with premultiplied alpha, weighted colors
// add up. Weights and colors are kept apart, so that neither overflows and the mean of equal colors
// is that color, bit for bit.

import package::common::tensor::TensorIn;

alias LightIn = texture_storage_2d_array<rgba32float, read>;
alias LightOut = texture_storage_2d_array<rgba32float, write>;

const MOST_LOGIT = 8.0;      // confidences and shares lie between exp(−8) and exp(8)
const LAST_QUAD = 2u;        // of the logits: the last tap, confidence and share

fn weight_of(logit: f32) -> f32 {
    return exp(clamp(logit, -MOST_LOGIT, MOST_LOGIT));
}

fn confidence(logits: vec4<f32>) -> f32 {
    return weight_of(logits.y);
}

fn share(logits: vec4<f32>) -> f32 {
    return weight_of(logits.z);
}

// The reciprocal of a sum of weights; 0 if nothing has any weight. The reciprocal of a smaller sum
// could be infinite.
fn inverse(sum: f32) -> f32 {
    return select(0.0, 1.0 / sum, sum >= 1.1754944e-38);
}

// The sum of four pixels, each times a factor.
fn sum_of_four(
    a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, factors: vec4<f32>,
) -> vec4<f32> {
    let weights = vec4(a.w, b.w, c.w, d.w) * factors;
    let sum = dot(weights, vec4(1.0));
    let parts = weights * inverse(sum);
    let color = mat4x3(a.rgb, b.rgb, c.rgb, d.rgb) * parts;
    let least = min(min(a.rgb, b.rgb), min(c.rgb, d.rgb));
    let most = max(max(a.rgb, b.rgb), max(c.rgb, d.rgb));
    return vec4(clamp(color, least, most), sum);
}

// The sum of two pixels, the second times a factor.
fn sum_of_two(a: vec4<f32>, b: vec4<f32>, factor: f32) -> vec4<f32> {
    let added = b.w * factor;
    let sum = a.w + added;
    let scale = inverse(sum);
    // `mix` would take 1 − t for the share of `a`, which loses its digits where t is almost 1.
    let color = a.rgb * (a.w * scale) + b.rgb * (added * scale);
    return vec4(clamp(color, min(a.rgb, b.rgb), max(a.rgb, b.rgb)), sum);
}
