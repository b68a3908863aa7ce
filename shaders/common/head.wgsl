// The end of the network after the sums of its 1×1 convolution: optional sigmoid, inverse transfer
// function, inverse exposure, crop, blend with the noisy color, store. Clean blocks instead
// receive their input.

import package::common::clean::is_clean;
import package::common::encoding::decode;
import package::common::result::{store_denoised, store_noisy};
import package::common::tensor::TensorIn;
import package::common::tile::tile;

@group(0) @binding(6) var input: TensorIn;
// Row = input quad, texel = input channel within it: what that channel adds to the outputs. The
// last row begins with the bias.
@group(0) @binding(7) var weights: texture_storage_2d_array<rgba32float, read>;

override sigmoid: bool;      // whether to apply one

// Stores the tile's pixel whose 1×1 convolution has these sums.
fn finish(pixel: vec2<i32>, sums: vec4<f32>) {
    let at = tile.origin + vec2<u32>(pixel);
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    if is_clean(vec2<u32>(pixel), textureDimensions(input).x) {
        store_noisy(at);
        return;
    }
    let bias = textureLoad(weights, vec2(0, i32(textureDimensions(weights).y) - 1), 0);
    // Beyond ±30 the sigmoid is within 1e-13 of 0 or 1, and exp stays far from overflow.
    let x = clamp(sums + bias, vec4(-30.0), vec4(30.0));
    let encoded = select(x, 1.0 / (1.0 + exp(-x)), sigmoid);
    store_denoised(at, decode(encoded.rgb));
}
