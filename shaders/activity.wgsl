// Finds the blocks of a tile that the network must work on, so that its layers can skip the others.
//
// `classify` finds the even blocks: either all pixels, repaired for the network, are equal, or no
// second difference exceeds BEND: along rows and columns, |v(i − 1) − 2 v(i) + v(i + 1)| <= BEND in
// each channel, where v is the color as the network sees it, except that light always uses PU.
// Empty background and noise-free gradients are even; noise with a standard deviation of BEND/4 is
// not. If the image ends inside a block, three pixels a side are still examined, if the image has
// them. A side shorter than three has no second difference, so such a block must be constant; an
// image of fewer than three pixels in all has nothing to compare with. One block per invocation,
// which stops at the first pixel that is not even.
//
// `settle` marks the clean blocks. Even blocks are clean unless they are dark: no channel of the
// first pixel, exposed, is above DARK. A dark block may be empty background or a surface that no
// path has lit yet. It is clean if albedo or normal is given and every given one is zero there, or
// if no block around it is noisy: that much darkness is no accident.
//
// A block is active if it is not clean and has pixels that the tile stores. `spread` writes the
// map. Layer 0: the distance in blocks, counting diagonal steps, to the nearest active block; FAR
// if none is within `radius`. Layer m, texel (x, y): the minimum of layer 0 over those of the 2^m ×
// 2^m blocks from (x, y) · 2^m that exist; texels without blocks are not written.

import package::common::albedo::load_albedo;
import package::common::block::BLOCK;
import package::common::encoding::encode;
import package::common::inputs::{has_albedo, has_normal, unorm_normal};
import package::common::normal::load_normal;
import package::common::repair::repaired;
import package::common::scale::input_scale;
import package::common::tile::tile;

// Whether each block is clean, row by row: 1 or 0. The findings of `classify` follow.
@group(0) @binding(5) var<storage, read_write> clean: array<u32>;
@group(0) @binding(6) var map: texture_storage_2d_array<r32uint, write>;

override radius: i32;        // search radius of `spread` in blocks, below FAR
override skip: bool;         // otherwise no block counts as clean

const FAR = 255u;
const BEND: f32 = 1.0 / 1024.0;
const DARK: f32 = 2e-6;      // by PU, about BEND

// The findings of `classify`.
const NOISY = 0u;
const DARK_BLOCK = 1u;
const CLEAN = 2u;

fn constant(first: vec2<u32>, size: vec2<u32>) -> bool {
    let rgb = repaired(first);
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            if any(repaired(first + vec2(x, y)) != rgb) {
                return false;
            }
        }
    }
    return true;
}

fn is_zero(bits: vec3<u32>) -> bool {
    return all((bits & vec3(0x7fffffffu)) == vec3(0u));
}

// A stored normal of length 0. Eight bits cannot represent 0.5: they miss it by half a step, 1/510.
fn is_no_normal(bits: vec3<u32>) -> bool {
    let middle = all(abs(bitcast<vec3<f32>>(bits) - 0.5) < vec3(1.0 / 500.0));
    return is_zero(bits) || (unorm_normal && middle);
}

// Whether albedo and normal, if given, show no surface.
fn empty(first: vec2<u32>, size: vec2<u32>) -> bool {
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            let at = first + vec2(x, y);
            if has_albedo && !is_zero(load_albedo(tile.albedo, at)) {
                return false;
            }
            if has_normal && !is_no_normal(load_normal(tile.normal, at)) {
                return false;
            }
        }
    }
    return has_albedo || has_normal;
}

// Whether no second difference in a line of `count` pixels exceeds BEND.
fn straight(first: vec2<u32>, step: vec2<u32>, count: u32) -> bool {
    var before = vec3(0.0);
    var here = vec3(0.0);
    for (var i = 0u; i < count; i++) {
        let after = encode(repaired(first + i * step) * input_scale);
        if i >= 2u && any(abs(before - 2.0 * here + after) > vec3(BEND)) {
            return false;
        }
        before = here;
        here = after;
    }
    return true;
}

fn smooth_lines(first: vec2<u32>, size: vec2<u32>) -> bool {
    for (var y = 0u; y < size.y; y++) {
        if !straight(first + vec2(0u, y), vec2(1u, 0u), size.x) {
            return false;
        }
    }
    for (var x = 0u; x < size.x; x++) {
        if !straight(first + vec2(x, 0u), vec2(0u, 1u), size.y) {
            return false;
        }
    }
    return true;
}

fn is_even(first: vec2<u32>, size: vec2<u32>) -> bool {
    return size.x * size.y < 3u
        || constant(first, size)
        || (all(size >= vec2(3u)) && smooth_lines(first, size));
}

fn find(block: vec2<u32>) -> u32 {
    let end = min(tile.origin + (block + 1u) * BLOCK, tile.image_size);
    let first = min(tile.origin + block * BLOCK, max(end, vec2(3u)) - 3u);
    let size = end - first;
    if !is_even(first, size) {
        return NOISY;
    }
    let is_dark = all(repaired(first) * input_scale <= vec3(DARK));
    return select(CLEAN, DARK_BLOCK, is_dark && !empty(first, size));
}

fn is_in_image(block: vec2<i32>) -> bool {
    let blocks = vec2<i32>(textureDimensions(map));
    let inside = all(block >= vec2(0)) && all(block < blocks);
    return inside && all(tile.origin + vec2<u32>(block) * BLOCK < tile.image_size);
}

fn place_of(block: vec2<u32>) -> u32 {
    return block.y * textureDimensions(map).x + block.x;
}

// Where `classify` stores its finding.
fn place_of_finding(block: vec2<u32>) -> u32 {
    let blocks = textureDimensions(map);
    return blocks.x * blocks.y + place_of(block);
}

@compute @workgroup_size(8, 8)
fn classify(@builtin(global_invocation_id) id: vec3<u32>) {
    let blocks = textureDimensions(map);
    if any(id.xy >= blocks) {
        return;
    }
    clean[place_of_finding(id.xy)] = NOISY;
    if skip && is_in_image(vec2<i32>(id.xy)) {
        clean[place_of_finding(id.xy)] = find(id.xy);
    }
}

fn is_noisy(block: vec2<i32>) -> bool {
    return is_in_image(block) && clean[place_of_finding(vec2<u32>(block))] == NOISY;
}

fn has_noise_around(block: vec2<i32>) -> bool {
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            if is_noisy(block + vec2(x, y)) {
                return true;
            }
        }
    }
    return false;
}

@compute @workgroup_size(8, 8)
fn settle(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(map)) {
        return;
    }
    let found = clean[place_of_finding(id.xy)];
    let is_dark_background = found == DARK_BLOCK && !has_noise_around(vec2<i32>(id.xy));
    clean[place_of(id.xy)] = u32(found == CLEAN || is_dark_background);
}

fn is_active(block: vec2<i32>) -> bool {
    if !is_in_image(block) {
        return false;
    }
    let first = tile.origin + vec2<u32>(block) * BLOCK;
    let stored = all(first + BLOCK > tile.begin) && all(first < tile.end);
    return stored && clean[place_of(vec2<u32>(block))] == 0u;
}

// Searches ring by ring, so that an active block is done at once.
fn distance_to_active(block: vec2<i32>) -> u32 {
    for (var d = 0; d <= radius; d++) {
        for (var i = -d; i <= d; i++) {
            if is_active(block + vec2(i, -d)) || is_active(block + vec2(i, d))
                || is_active(block + vec2(-d, i)) || is_active(block + vec2(d, i)) {
                return u32(d);
            }
        }
    }
    return FAR;
}

const LAYERS = 5u;
const SIDE = 16u;            // blocks per side of a workgroup: one texel of the last layer
var<workgroup> nearest: array<u32, SIDE * SIDE>;

@compute @workgroup_size(16, 16)
fn spread(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) cell: u32,
) {
    // A block that does not exist counts as FAR, which changes no minimum.
    let exists = all(id.xy < textureDimensions(map));
    nearest[cell] = FAR;
    if exists {
        nearest[cell] = distance_to_active(vec2<i32>(id.xy));
        textureStore(map, id.xy, 0, vec4(nearest[cell]));
    }
    for (var layer = 1u; layer < LAYERS; layer++) {
        workgroupBarrier();
        let half = 1u << (layer - 1u);
        if all(local.xy % (2u * half) == vec2(0u)) {
            let upper = min(nearest[cell], nearest[cell + half]);
            let lower = min(nearest[cell + SIDE * half], nearest[cell + SIDE * half + half]);
            nearest[cell] = min(upper, lower);
            if exists {
                textureStore(map, id.xy >> vec2(layer), layer, vec4(nearest[cell]));
            }
        }
    }
}
