// The last 3×3 convolution of a kernel pyramid on matrix units, and the 1×1 convolution to its
// logits: from the sums in workgroup memory to the store. The 1×1 convolution is in 32-bit floats.

import package::common::conv_logits::feature_of;
import package::common::conv_output::{activated, bias, output};
import package::common::logits::logits_of;
import package::common::matrix::{SIDE, sum_of};

// Four channels of pixel x, from the sums that start at `place`.
fn features(place: u32, x: u32, quad: u32) -> vec4<f32> {
    return feature_of(sum_of(place, x, quad) + bias[quad]);
}

// Stores the logits of a subgroup's pixels, one quad of a pixel per invocation at a time.
fn put_logits(at: vec2<i32>, place: u32, lane: u32, lanes: u32) {
    for (var i = lane; i < SIDE * textureNumLayers(output); i += lanes) {
        let x = i % SIDE;
        let quad = i / SIDE;
        let sum = logits_of(quad, features(place, x, 0u), features(place, x, 1u),
            features(place, x, 2u), features(place, x, 3u));
        // Stores outside the tensor do nothing.
        textureStore(output, at + vec2(2 * i32(x), 0), quad, activated(sum));
    }
}
