// The last 3×3 convolution and the head for GPUs: a workgroup makes 16×16 pixels, a whole block, each
// invocation 2×2 of all channels, which are 16 at most.

import package::common::conv_head::{conv_bias, is_needed, relu};
import package::common::conv_sums::{TILE, convolve};
import package::common::head::{finish, weights};

// What a quad of the 3×3 convolution adds to the sums of the 1×1 one at the four pixels.
fn project(quad: u32, a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>) -> mat4x4<f32> {
    let w = mat4x4(
        textureLoad(weights, vec2(0u, quad), 0),
        textureLoad(weights, vec2(1u, quad), 0),
        textureLoad(weights, vec2(2u, quad), 0),
        textureLoad(weights, vec2(3u, quad), 0),
    );
    let bias = conv_bias[quad];
    return mat4x4(
        w * relu(a + bias),
        w * relu(b + bias),
        w * relu(c + bias),
        w * relu(d + bias),
    );
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = group.xy * TILE;
    var result = mat4x4<f32>();
    // The same for the whole workgroup.
    if is_needed(corner, vec2(TILE)) {
        let s = convolve(vec2<i32>(corner), local.xy * 2u, 0u, lane);
        result += project(0u, s.a0, s.b0, s.c0, s.d0);
        result += project(1u, s.a1, s.b1, s.c1, s.d1);
        result += project(2u, s.a2, s.b2, s.c2, s.d2);
        result += project(3u, s.a3, s.b3, s.c3, s.d3);
    }
    let at = vec2<i32>(corner + local.xy * 2u);
    finish(at, result[0]);
    finish(at + vec2(1, 0), result[1]);
    finish(at + vec2(0, 1), result[2]);
    finish(at + vec2(1, 1), result[3]);
}
