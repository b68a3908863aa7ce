// The denoised image: 32-bit floats in a buffer, 16-bit floats in a buffer, or a texture.

import package::common::layout::element_of;
@if(output_f16 || output_rgba16float) import package::common::limits::LARGEST_F16;
@if(output_rgba32float) import package::common::limits::LARGEST_F32;
import package::common::tile::tile;

@if(output_f16)
@group(0) @binding(2) var<storage, read_write> output: array<atomic<u32>>;
@elif(output_rgba16float)
@group(0) @binding(2) var output: texture_storage_2d<rgba16float, write>;
@elif(output_rgba32float)
@group(0) @binding(2) var output: texture_storage_2d<rgba32float, write>;
@else
@group(0) @binding(2) var<storage, read_write> output: array<f32>;

@if(output_f16 || output_rgba16float) const LARGEST_STORED = LARGEST_F16;
@elif(output_rgba32float) const LARGEST_STORED = LARGEST_F32;

// Two elements share a word, possibly across pixels, so each store changes only its own bits.
@if(output_f16)
fn store_element(i: u32, value: f32) {
    let half = pack2x16float(vec2(clamp(value, -LARGEST_STORED, LARGEST_STORED), 0.0));
    let shift = 16u * (i & 1u);
    atomicAnd(&output[i / 2u], ~(0xffffu << shift));
    atomicOr(&output[i / 2u], half << shift);
}
@elif(!output_rgba16float && !output_rgba32float)
fn store_element(i: u32, value: f32) {
    output[i] = value;
}

// Finite values beyond the format's range are clamped.
@if(output_rgba16float || output_rgba32float)
fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    let most = vec4(LARGEST_STORED);
    textureStore(output, at, clamp(vec4(rgb, alpha), -most, most));
}
@else
fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    let i = element_of(tile.output, at);
    store_element(i, rgb.r);
    store_element(i + 1u, rgb.g);
    store_element(i + 2u, rgb.b);
    if tile.output.channels == 4u {
        store_element(i + 3u, alpha);
    }
}
