// Averages a denoised frame with the last ones along the motion of the surface that a pixel sees,
// as far as both show the same. One pixel of the image per invocation.

import package::common::history::{keep, keep_softness, softness_at};
import package::common::inputs::{has_albedo, has_normal};
import package::common::light::{GREY, is_finite};
import package::common::mean::mean_with;
import package::common::motion::last_place;
import package::common::output::store;
import package::common::patch::{Past, past_at};
import package::common::seen::{Seen, denoised, has_depth, seen_around};
import package::common::spline::{sharpened, sharpness};
import package::common::tile::tile;

struct Settings {
    longest: f32,            // the maximum number of past frames that count
    starts_anew: u32,        // whether this frame ignores the history
}

@group(0) @binding(10) var<uniform> settings: Settings;

// Differences at which agreement falls to 1/e: albedo, normals, and light and depth relative to
// their mean.
const ALBEDO = 0.1;
const NORMAL = 0.2;
const LIGHT = 0.3;
const DEPTH = 0.1;
const DARK = 0.005 * GREY;   // light far below the image's mean counts as equal
const DIFFERENT = 100.0;     // exp(-DIFFERENT) times any count changes no mean

fn mean_of(channels: vec3<f32>) -> f32 {
    return dot(channels, vec3(1.0 / 3.0));
}

fn square(v: f32) -> f32 {
    return v * v;
}

// How well two pixels agree, from 0 to 1.
fn agreement(own: Seen, other: Seen) -> f32 {
    let mean = mean_of(max(own.light, vec3(0.0)) + max(other.light, vec3(0.0))) / 2.0;
    var squares = square(mean_of(abs(own.light - other.light)) / (mean + DARK) / LIGHT);
    if has_albedo {
        squares += square(mean_of(abs(own.albedo - other.albedo)) / ALBEDO);
    }
    if has_normal {
        squares += square(mean_of(abs(own.normal - other.normal)) / NORMAL);
    }
    if has_depth && own.depth != other.depth {
        let relative = 2.0 * abs(own.depth - other.depth) / (own.depth + other.depth);
        squares += square(relative / DEPTH);
    }
    return exp(-min(squares, DIFFERENT));
}

// How many past frames count in addition to this one.
fn frames_of(place: vec3<f32>, past: Past, own: Seen) -> f32 {
    let is_known = place.z > 0.0 && past.count > 0.0 && settings.starts_anew == 0u;
    let frames = agreement(own, past.seen) * min(past.count, settings.longest);
    return select(0.0, frames, is_known);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= tile.image_size) {
        return;
    }
    let frame = textureLoad(denoised, id.xy, 0);
    let own = seen_around(id.xy);
    let place = last_place(id.xy);
    let past = past_at(place.xy);
    let frames = frames_of(place, past, own);
    let share = min(sharpness(past.color), 1.0 - softness_at(id.xy));
    let mean = mean_with(sharpened(past.color, share), frames, frame.rgb);
    store(id.xy, mean.rgb, frame.a);
    let is_number = is_finite(bitcast<vec3<u32>>(mean.rgb));
    let count = select(0.0, 1.0 + mean.w, is_number);
    keep(id.xy, select(vec3(0.0), mean.rgb, is_number), count, own);
    keep_softness(id.xy, 1.0 - share);
}
