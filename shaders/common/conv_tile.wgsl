// A workgroup's tile of a 3×3 convolution, from the sums to the store. If the kernel pools, it also
// stores the maximum of an invocation's 2×2 pixels as one pixel of the smaller tensor. If it begins
// a decoder level, it adds the sums of the upsampled tensor.

import package::common::conv_bias::bias_at;
import package::common::conv_output::{activated, output};
import package::common::conv_sums::{HEIGHT, QUADS, WIDTH, convolve, square_of};
import package::common::need::is_needed;
@if(pools) import package::common::tensor::TensorOut;
@if(up_conv) import package::up_conv_tiled::convolve_low;

@if(pools) @group(0) @binding(6) var pooled: TensorOut;

fn store_pixel(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    // Stores outside the tensor do nothing.
    textureStore(output, at, quad, activated(sum + bias_at(at, quad)));
}

fn store(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, at: vec2<i32>, quad: u32) {
    store_pixel(a, at, quad);
    store_pixel(b, at + vec2(1, 0), quad);
    store_pixel(c, at + vec2(0, 1), quad);
    store_pixel(d, at + vec2(1, 1), quad);
    @if(pools)
    textureStore(pooled, at / 2, quad, activated(max(max(a, b), max(c, d)) + bias_at(at, quad)));
}

fn make_tile(group: vec3<u32>, lane: u32) {
    let corner = vec2<i32>(group.xy * vec2(WIDTH, HEIGHT));
    // Uniform across the workgroup.
    if !is_needed(corner) {
        return;
    }
    @if(up_conv)
    let sums = convolve_low(convolve(corner, group.z, lane), corner, group.z, lane);
    @else
    let sums = convolve(corner, group.z, lane);
    let at = corner + vec2<i32>(square_of(lane) * 2u);
    let quad = group.z * QUADS;
    store(sums.a0, sums.b0, sums.c0, sums.d0, at, quad);
    store(sums.a1, sums.b1, sums.c1, sums.d1, at, quad + 1u);
    store(sums.a2, sums.b2, sums.c2, sums.d2, at, quad + 2u);
    store(sums.a3, sums.b3, sums.c3, sums.d3, at, quad + 3u);
}
