// Reads light between the pixels of an image, from the 4×4 around a place that have any. Beyond the
// image, its edge repeats.

import package::common::light::MOST;
import package::common::tile::tile;

// The rounding error of a spline, relative to the light: its 16 absolute weights add up to at most
// 1.25², and sums, products and weights have 26 roundings of 2⁻²⁴.
const ROUNDING = 3e-6;

// Along x and along y.
struct Weights {
    spline: array<vec4<f32>, 2>,
    linear: array<vec4<f32>, 2>,
}

struct Reading {
    spline: vec3<f32>,       // sum with Catmull-Rom weights
    linear: vec4<f32>,       // sum with bilinear shares, with the sum of the shares in w
    least: vec3<f32>,        // of the four nearest pixels
    most: vec3<f32>,
    is_whole: bool,          // all pixels have light
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

fn weights_at(place: vec2<f32>) -> Weights {
    let t = place - floor(place);
    return Weights(
        array(spline_weights(t.x), spline_weights(t.y)),
        array(linear_weights(t.x), linear_weights(t.y)),
    );
}

fn linear_share(weights: Weights, step: vec2<u32>) -> f32 {
    return weights.linear[0][step.x] * weights.linear[1][step.y];
}

// Pixel (1, 1) is the nearest one to the left and above.
fn pixel_at(place: vec2<f32>, step: vec2<u32>) -> vec2<u32> {
    let at = vec2<i32>(floor(place)) + vec2<i32>(step) - 1;
    return vec2<u32>(clamp(at, vec2(0), vec2<i32>(tile.image_size) - 1));
}

fn nothing_read() -> Reading {
    return Reading(vec3(0.0), vec4(0.0), vec3(MOST), vec3(-MOST), true);
}

// Adds a pixel: its light; w is 0 if it has none.
fn with_pixel(so_far: Reading, weights: Weights, step: vec2<u32>, kept: vec4<f32>) -> Reading {
    var reading = so_far;
    let has_light = kept.w > 0.0;
    let share = select(0.0, 1.0, has_light) * linear_share(weights, step);
    reading.spline += weights.spline[0][step.x] * weights.spline[1][step.y] * kept.rgb;
    reading.linear += share * vec4(kept.rgb, 1.0);
    let is_near = has_light && all(step - 1u < vec2(2u));
    reading.least = select(reading.least, min(reading.least, kept.rgb), is_near);
    reading.most = select(reading.most, max(reading.most, kept.rgb), is_near);
    reading.is_whole &= has_light;
    return reading;
}

fn bilinear(reading: Reading) -> vec3<f32> {
    return clamp(reading.linear.rgb / reading.linear.w, reading.least, reading.most);
}

// The largest share of what splines add to the bilinear mean that keeps all channels in the range
// of the four nearest pixels. Where light is constant, rounding leaves that range, which must not
// soften the other images.
fn sharpness(reading: Reading) -> f32 {
    let linear = bilinear(reading);
    let change = reading.spline - linear;
    let room = select(linear - reading.least, reading.most - linear, change > vec3(0.0));
    let rounding = ROUNDING * max(abs(reading.least), abs(reading.most));
    let shares = select(vec3(1.0), room / abs(change), abs(change) > room + rounding);
    return select(0.0, min(shares.x, min(shares.y, shares.z)), reading.is_whole);
}

// The bilinear mean with a share of what splines add.
fn sharpened(reading: Reading, share: f32) -> vec3<f32> {
    let linear = bilinear(reading);
    return clamp(linear + share * (reading.spline - linear), reading.least, reading.most);
}
