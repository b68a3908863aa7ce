// From images to the network's input: repair, expose, transfer function, channel layout and
// padding. One pixel of the tile per invocation. Each image that is present has a layer of its
// own, colour, then albedo, then normal, so that leaving one out moves no other channel and sums
// keep their order. Pixels right of or below the image repeat its edge, or are 0.

alias TensorOut = texture_storage_2d_array<rgba32float, write>;

struct Tile {
    image_size: vec2<u32>,   // of the bound images, pixels
    origin: vec2<u32>,       // the tile's first pixel in the bound images
    begin: vec2<u32>,        // the pixels that output_process stores: from `begin`
    end: vec2<u32>,          // up to and without `end`, in the bound images
    color: vec4<u32>,        // offset, row stride, pixel stride, in elements
    albedo: vec4<u32>,
    normal: vec4<u32>,
    output: vec4<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
// Bindings 1 to 3: the images `color`, `albedo` and `normal`, read, filled, repaired and encoded by
// texts of shaders/image.
@group(0) @binding(4) var<storage, read> input_scale: f32;
@group(0) @binding(5) var output: TensorOut;

override has_albedo: bool;
override has_normal: bool;
override unorm_normal: bool; // whether normals are stored as 0.5 n + 0.5, and 0 where there is none
override zero_padding: bool; // whether the input is 0 right of and below the image

fn encoded_color(at: vec2<u32>) -> vec4<f32> {
    if transfer_function == SIGNED {
        return vec4(encode(filled_color(at) * input_scale), 0.0);
    }
    return vec4(encode(repaired_color(at) * input_scale), 0.0);
}

fn encoded_albedo(at: vec2<u32>) -> vec4<f32> {
    return vec4(clamp(filled_albedo(at), vec3(0.0), vec3(1.0)), 0.0);
}

fn encoded_normal(at: vec2<u32>) -> vec4<f32> {
    let xyz = filled_normal(at);
    if unorm_normal {
        let stored = clamp(xyz, vec3(0.0), vec3(1.0));
        return vec4(select(stored, vec3(0.5), all(xyz == vec3(0.0))), 0.0);
    }
    return vec4(clamp(xyz, vec3(-1.0), vec3(1.0)) * 0.5 + 0.5, 0.0);
}

// A pixel of the tile as it stands in the bound images.
fn place(pixel: vec2<u32>) -> vec2<u32> {
    return min(tile.origin + pixel, tile.image_size - 1u);
}

// A value of the pixel, or what stands for it outside of the image.
fn padded(value: vec4<f32>, pixel: vec2<u32>) -> vec4<f32> {
    let is_outside = any(tile.origin + pixel >= tile.image_size);
    return select(value, vec4<f32>(), zero_padding && is_outside);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(output)) {
        return;
    }
    let at = place(id.xy);
    textureStore(output, id.xy, 0, stored(padded(encoded_color(at), id.xy)));
    if has_albedo {
        textureStore(output, id.xy, 1, stored(padded(encoded_albedo(at), id.xy)));
    }
    if has_normal {
        let layer = 1 + u32(has_albedo);
        textureStore(output, id.xy, layer, stored(padded(encoded_normal(at), id.xy)));
    }
}
