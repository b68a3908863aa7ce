// Demodulation: the weights that gather light also gather the albedo, and gathered light is
// multiplied by the ratio of the pixel's own albedo to the gathered one, to the power that the
// network predicts. So gathering blurs the noise but not the texture. Without the feature, light
// stays as it is.

import package::common::weighted::{MOST_LOGIT, Pixel};

const FLOOR = 0.05;          // added to the albedo: noise in black is not texture
const GAIN = 8.0;            // of the logit of the power

// `own` is the pixel's albedo, `logits` the last quad of its logits. The factor is at most 21, and
// exactly 1 where the albedos are equal.
@if(demodulates)
fn modulated(gathered: Pixel, own: vec3<f32>, logits: vec4<f32>) -> vec3<f32> {
    // Beyond the limits the power is 0 or 1, and the exponential could be infinite.
    let power = 1.0 / (1.0 + exp(-GAIN * clamp(logits.w, -MOST_LOGIT, MOST_LOGIT)));
    let ratio = (own + FLOOR) / (gathered.albedo + FLOOR);
    let factor = select(exp(power * log(ratio)), vec3(1.0), own == gathered.albedo);
    return gathered.color * factor;
}
@else
fn modulated(gathered: Pixel, own: vec3<f32>, logits: vec4<f32>) -> vec3<f32> {
    return gathered.color;
}
