// The 1×1 convolution to the logits of a kernel pyramid, for kernels that hold all 16 channels of a
// pixel.

import package::common::conv_logits::logits_bias;

// [quad of logits][quad of the 3×3 convolution]: column j holds what channel j adds to four logits.
@group(0) @binding(6) var<storage, read> logits_weights: array<mat4x4<f32>>;

const HELD = 4u;             // quads of the 3×3 convolution

fn logits_of(quad: u32, v0: vec4<f32>, v1: vec4<f32>, v2: vec4<f32>, v3: vec4<f32>) -> vec4<f32> {
    let first = quad * HELD;
    return logits_weights[first] * v0 + logits_weights[first + 1u] * v1
        + logits_weights[first + 2u] * v2 + logits_weights[first + 3u] * v3 + logits_bias[quad];
}
