// The last 3×3 convolution of a kernel pyramid and the 1×1 convolution to its logits, for GPUs.
// Each invocation computes 2×2 pixels with all channels, at most 16.

import package::common::conv_logits::feature_of;
import package::common::conv_output::{activated, bias, output};
import package::common::conv_sums::{HEIGHT, WIDTH, convolve, square_of};
import package::common::logits::logits_of;
import package::common::need::is_needed;

// Stores the logits of a pixel from the sums of its 3×3 convolution.
fn store(at: vec2<i32>, s0: vec4<f32>, s1: vec4<f32>, s2: vec4<f32>, s3: vec4<f32>) {
    let v0 = feature_of(s0 + bias[0]);
    let v1 = feature_of(s1 + bias[1]);
    let v2 = feature_of(s2 + bias[2]);
    let v3 = feature_of(s3 + bias[3]);
    for (var quad = 0u; quad < textureNumLayers(output); quad++) {
        // Stores outside the tensor do nothing.
        textureStore(output, at, quad, activated(logits_of(quad, v0, v1, v2, v3)));
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = vec2<i32>(group.xy * vec2(WIDTH, HEIGHT));
    // Uniform across the workgroup.
    if !is_needed(corner) {
        return;
    }
    let s = convolve(corner, 0u, lane);
    let at = corner + vec2<i32>(square_of(lane) * 2u);
    store(at, s.a0, s.a1, s.a2, s.a3);
    store(at + vec2(1, 0), s.b0, s.b1, s.b2, s.b3);
    store(at + vec2(0, 1), s.c0, s.c1, s.c2, s.c3);
    store(at + vec2(1, 1), s.d0, s.d1, s.d2, s.d3);
}
