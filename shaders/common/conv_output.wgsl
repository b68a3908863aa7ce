// The output of a convolution: bias, optional ReLU, clamp.

import package::common::tensor::{TensorOut, stored};

@if(input_conv) @group(0) @binding(5) var output: TensorOut;
@else @group(0) @binding(1) var output: TensorOut;

// One vector per output quad; for up_conv [above, inside, below][left, inside, right][output quad].
@if(input_conv) @group(0) @binding(7) var<storage, read> bias: array<vec4<f32>>;
@else @group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;

override relu: bool;
// The largest value of the tensor's format: converting f32 to f16 does not saturate by itself.
override largest: f32;

// A sum that includes its bias, activated and clamped for the tensor.
fn activated(sum: vec4<f32>) -> vec4<f32> {
    let floor = select(-largest, 0.0, relu);
    return stored(clamp(sum, vec4(floor), vec4(largest)));
}
