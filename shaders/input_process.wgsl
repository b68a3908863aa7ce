// Turns images into the network's input: repair, exposure, transfer function, channel layout and
// padding. One pixel of the tile per invocation. Each given image has a layer of its own, in the
// order color, albedo, normal, so that leaving one out moves no other channel within its layer and
// sums keep their order. Pixels to the right of or below the image repeat its edge, or are 0.

import package::common::encoded::{encoded_albedo, encoded_color, encoded_normal};
import package::common::inputs::{has_albedo, has_normal};
import package::common::place::place;
import package::common::tensor::{TensorOut, stored};
import package::common::tile::tile;

@group(0) @binding(5) var output: TensorOut;

override zero_padding: bool; // whether the input is 0 right of and below the image

// The value of the pixel, or its replacement outside the image.
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
