// The max-pool after the 3×3 convolution on matrix units: the function that generated code calls.

import package::common::matrix::{SIDE, SUMS_USED};
import package::common::tensor::TensorOut;

@group(0) @binding(6) var pooled: TensorOut;

// Stores the maximum of four pixels. `at`, the position of the first, and `i`, the quad's number
// among the sums, give its position in the smaller tensor.
fn pool(at: vec2<i32>, quad: u32, i: u32, most: vec4<f32>) {
    if i < SUMS_USED / 4u {
        textureStore(pooled, at / 2 + vec2(i32(i % SIDE), 0), quad + i / SIDE, most);
    }
}
