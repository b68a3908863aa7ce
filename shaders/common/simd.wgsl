// Shared by the generated convolutions for CPU drivers.

import package::common::conv_output::output;
import package::common::need::is_needed;

// Layer = block of output channels, row = kernel row × input quad, texel = tap × input channel ×
// output quad.
@group(0) @binding(2) var weights: texture_storage_2d_array<rgba32float, read>;

// Whether any lane's pixels are needed. All lanes run the loops together, since each reads weights
// for the others.
fn any_needed(x: i32, y: i32) -> bool {
    let size = vec2<i32>(textureDimensions(output));
    return subgroupAny(is_needed(min(vec2(x, y), size - 1)));
}
