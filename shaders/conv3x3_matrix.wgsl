// The 3×3 convolution on matrix units, with the max-pool that follows: the function that generated
// code calls for it.

import package::common::matrix::{SIDE, SUMS_USED};
import package::common::tensor::TensorOut;

@group(0) @binding(6) var pooled: TensorOut;

// Stores the maximum of four pixels, whose position in the smaller tensor follows from that of the
// first, `at`, and from the quad's number among the sums.
fn pool(at: vec2<i32>, quad: u32, i: u32, most: vec4<f32>) {
    if i < SUMS_USED / 4u {
        textureStore(pooled, at / 2 + vec2(i32(i % SIDE), 0), quad + i / SIDE, most);
    }
}
