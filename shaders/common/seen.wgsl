// The light and features of a pixel, as means of 3×3 pixels, because features are noisy. The albedo
// and normal kept for the next frame are rounded to bytes, and so are those compared with them, so
// that what stays the same does not seem to change.

import package::common::albedo::load_albedo;
import package::common::depth::load_depth;
import package::common::inputs::{has_albedo, has_normal, unorm_normal};
import package::common::light::{INFINITE, MOST, is_finite};
import package::common::normal::load_normal;
import package::common::scale::input_scale;
import package::common::tile::tile;

override has_depth: bool;

// The denoised frame.
@group(0) @binding(7) var denoised: texture_2d<f32>;

struct Seen {
    light: vec3<f32>,        // at the network's exposure
    albedo: vec3<f32>,
    normal: vec3<f32>,
    depth: f32,              // mean of the pixels that hit something; 0 if none does
}

fn exposed(rgb: vec3<f32>) -> vec3<f32> {
    return clamp(rgb * input_scale, vec3(-MOST), vec3(MOST));
}

// 0 where it is not finite.
fn albedo_at(at: vec2<u32>) -> vec3<f32> {
    let bits = load_albedo(tile.albedo, at);
    return saturate(bitcast<vec3<f32>>(select(vec3(0u), bits, is_finite(bits))));
}

// 0 where it is not finite.
fn normal_at(at: vec2<u32>) -> vec3<f32> {
    let bits = load_normal(tile.normal, at);
    let xyz = bitcast<vec3<f32>>(select(vec3(0u), bits, is_finite(bits)));
    let is_encoded = unorm_normal && any(xyz != vec3(0.0));
    return clamp(select(xyz, 2.0 * xyz - 1.0, is_encoded), vec3(-1.0), vec3(1.0));
}

// 0 where nothing was hit.
fn depth_at(at: vec2<u32>) -> f32 {
    let bits = load_depth(tile.depth, at);
    let number = bitcast<f32>(select(bits, 0u, (bits & INFINITE) == INFINITE));
    return clamp(number, 0.0, MOST);
}

fn packed_albedo(albedo: vec3<f32>) -> u32 {
    return pack4x8unorm(vec4(albedo, 0.0));
}

fn packed_normal(normal: vec3<f32>) -> u32 {
    return pack4x8snorm(vec4(normal, 0.0));
}

// Beyond the image, its edge repeats.
fn seen_around(at: vec2<u32>) -> Seen {
    var sum = Seen();
    var hits = 0.0;
    for (var i = 0; i < 9; i++) {
        let place = vec2<i32>(at) + vec2(i % 3, i / 3) - 1;
        let there = vec2<u32>(clamp(place, vec2(0), vec2<i32>(tile.image_size) - 1));
        sum.light += exposed(textureLoad(denoised, there, 0).rgb);
        if has_albedo {
            sum.albedo += albedo_at(there);
        }
        if has_normal {
            sum.normal += normal_at(there);
        }
        if has_depth {
            let depth = depth_at(there);
            sum.depth += depth;
            hits += select(0.0, 1.0, depth > 0.0);
        }
    }
    return Seen(
        sum.light / 9.0,
        unpack4x8unorm(packed_albedo(sum.albedo / 9.0)).rgb,
        unpack4x8snorm(packed_normal(sum.normal / 9.0)).xyz,
        sum.depth / max(hits, 1.0),
    );
}
