// Finds the blocks of a tile that the network must process, so that its layers can skip the others.
//
// A block is clean if it and all blocks within `constant_radius` blocks, counting diagonal steps,
// have exactly the same finite color everywhere; blocks outside the image or the tile do not count.
// A kernel pyramid gathers color from no further and maps a constant to itself, so skipping is
// invisible; one that demodulates would print a texture on it that the light does not have.
// Networks that output color see further, so skipping may change their result slightly; there the
// radius is at most three. `classify` finds the constant blocks, one per invocation, which stops at
// the first pixel that differs. `settle` compares the blocks with each other.
//
// A block is active if it is not clean and has pixels that the tile stores. `spread` writes the
// map. Layer 0: the distance in blocks, counting diagonal steps, to the nearest active block; FAR
// if none is within `radius`. Layer m, texel (x, y): the minimum of layer 0 over those of the 2^m ×
// 2^m blocks from (x, y) · 2^m that exist; texels without blocks are not written.

import package::common::block::BLOCK;
import package::common::color::load_color;
import package::common::light::is_finite;
import package::common::tile::tile;

// Whether each block is clean, row by row: 1 or 0. A second list holds whether it is constant.
@group(0) @binding(2) var<storage, read_write> clean: array<u32>;
@group(0) @binding(3) var map: texture_storage_2d_array<r32uint, write>;

override radius: i32;        // search radius of `spread` in blocks, below FAR
override constant_radius: i32;   // radius of `settle`; if negative, no block counts as clean

const FAR = 255u;

// The bits of a color, with 0 for −0.
fn color_at(at: vec2<u32>) -> vec3<u32> {
    let bits = load_color(tile.color, at);
    return select(bits, vec3(0u), bits == vec3(0x80000000u));
}

fn first_of(block: vec2<u32>) -> vec2<u32> {
    return tile.origin + block * BLOCK;
}

fn is_constant(block: vec2<u32>) -> bool {
    let first = first_of(block);
    let end = min(first + BLOCK, tile.image_size);
    let color = color_at(first);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            if any(color_at(vec2(x, y)) != color) {
                return false;
            }
        }
    }
    return is_finite(color);
}

fn is_in_image(block: vec2<i32>) -> bool {
    let blocks = vec2<i32>(textureDimensions(map));
    let inside = all(block >= vec2(0)) && all(block < blocks);
    return inside && all(first_of(vec2<u32>(block)) < tile.image_size);
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
    if any(id.xy >= textureDimensions(map)) {
        return;
    }
    clean[place_of_finding(id.xy)] = 0u;
    if constant_radius >= 0 && is_in_image(vec2<i32>(id.xy)) {
        clean[place_of_finding(id.xy)] = u32(is_constant(id.xy));
    }
}

// Whether the block has this color everywhere, or does not count.
fn agrees(block: vec2<i32>, color: vec3<u32>) -> bool {
    if !is_in_image(block) {
        return true;
    }
    let there = vec2<u32>(block);
    return clean[place_of_finding(there)] != 0u && all(color_at(first_of(there)) == color);
}

fn all_agree_around(block: vec2<i32>) -> bool {
    let color = color_at(first_of(vec2<u32>(block)));
    for (var y = -constant_radius; y <= constant_radius; y++) {
        for (var x = -constant_radius; x <= constant_radius; x++) {
            if !agrees(block + vec2(x, y), color) {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(8, 8)
fn settle(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(map)) {
        return;
    }
    let is_constant = clean[place_of_finding(id.xy)] != 0u;
    var is_clean = false;
    if is_constant {
        is_clean = all_agree_around(vec2<i32>(id.xy));
    }
    clean[place_of(id.xy)] = u32(is_clean);
}

fn is_active(block: vec2<i32>) -> bool {
    if !is_in_image(block) {
        return false;
    }
    let first = first_of(vec2<u32>(block));
    let stored = all(first + BLOCK > tile.begin) && all(first < tile.end);
    return stored && clean[place_of(vec2<u32>(block))] == 0u;
}

// Searches ring by ring, so that an active block finishes at once.
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
