// The 1×1 convolution after the last 3×3 convolution of a kernel pyramid. The 3×3 result stays in
// registers as 32-bit floats.

import package::common::limits::LARGEST_F32;

@group(0) @binding(7) var<storage, read> logits_bias: array<vec4<f32>>;

// A sum beyond the range of 32-bit floats becomes the largest of them, as in conv3x3.wgsl: in the
// 1×1 convolution, infinity times 0 would be NaN.
fn feature_of(sum: vec4<f32>) -> vec4<f32> {
    return clamp(sum, vec4(0.0), vec4(LARGEST_F32));
}
