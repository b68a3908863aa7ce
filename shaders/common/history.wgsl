// The history that a frame leaves for the next one. Each 32-bit word of a pixel has a plane of its
// own: red, green, blue and how many frames their mean counts, 0 for none; then as many of albedo,
// normal and depth as the pass has. With further layers of the image, one more plane is for the
// layers of this frame: the softness, the share of what splines add to the bilinear mean that is
// left out.

import package::common::inputs::{has_albedo, has_normal};
import package::common::seen::{Seen, has_depth, packed_albedo, packed_normal};
import package::common::tile::tile;

override has_layers: bool;

@group(0) @binding(8) var<storage, read> last: array<u32>;
@group(0) @binding(9) var<storage, read_write> next: array<u32>;

const COUNT = 3u;            // the plane of the count

fn word_of(plane: u32, at: vec2<u32>) -> u32 {
    return (plane * tile.image_size.y + at.y) * tile.image_size.x + at.x;
}

fn normal_plane() -> u32 {
    return COUNT + 1u + u32(has_albedo);
}

fn depth_plane() -> u32 {
    return normal_plane() + u32(has_normal);
}

fn softness_plane() -> u32 {
    return depth_plane() + u32(has_depth);
}

fn number(plane: u32, at: vec2<u32>) -> f32 {
    return bitcast<f32>(last[word_of(plane, at)]);
}

// The mean color, with the number of frames it counts in w.
fn kept_color(at: vec2<u32>) -> vec4<f32> {
    return vec4(number(0u, at), number(1u, at), number(2u, at), number(COUNT, at));
}

fn kept_albedo(at: vec2<u32>) -> vec3<f32> {
    return unpack4x8unorm(last[word_of(COUNT + 1u, at)]).rgb;
}

fn kept_normal(at: vec2<u32>) -> vec3<f32> {
    return unpack4x8snorm(last[word_of(normal_plane(), at)]).xyz;
}

fn kept_depth(at: vec2<u32>) -> f32 {
    return number(depth_plane(), at);
}

fn keep(at: vec2<u32>, color: vec3<f32>, count: f32, seen: Seen) {
    next[word_of(0u, at)] = bitcast<u32>(color.r);
    next[word_of(1u, at)] = bitcast<u32>(color.g);
    next[word_of(2u, at)] = bitcast<u32>(color.b);
    next[word_of(COUNT, at)] = bitcast<u32>(count);
    if has_albedo {
        next[word_of(COUNT + 1u, at)] = packed_albedo(seen.albedo);
    }
    if has_normal {
        next[word_of(normal_plane(), at)] = packed_normal(seen.normal);
    }
    if has_depth {
        next[word_of(depth_plane(), at)] = bitcast<u32>(seen.depth);
    }
}

// The softness that the layers need.
fn softness_at(at: vec2<u32>) -> f32 {
    if has_layers {
        return bitcast<f32>(next[word_of(softness_plane(), at)]);
    }
    return 0.0;
}

fn keep_softness(at: vec2<u32>, softness: f32) {
    if has_layers {
        next[word_of(softness_plane(), at)] = bitcast<u32>(softness);
    }
}
