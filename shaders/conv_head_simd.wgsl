// The last 3×3 convolution and the head for CPU drivers: what the generated code calls.

import package::common::conv_head::is_needed;

// Row = kernel row × input quad, texel = tap × input channel × output quad.
@group(0) @binding(9) var conv_weights: texture_storage_2d_array<rgba32float, read>;

const PIXELS = 4u;           // of a row that an invocation makes

// Whether any lane's pixels are needed: all lanes take the loops together, since each reads
// weights for the others.
fn any_needed(x: i32, y: i32) -> bool {
    return subgroupAny(is_needed(vec2<u32>(vec2(x, y)), vec2(PIXELS, 1u)));
}
