// The last 3×3 convolution in one kernel with the head, whose `weights` are those of the 1×1
// convolution. The result of the 3×3 one stays in registers as 32-bit floats.

import package::common::head::is_clean;
import package::common::limits::LARGEST_F32;
import package::common::tile::tile;

@group(0) @binding(8) var<storage, read> conv_bias: array<vec4<f32>>;

// A sum that left the range of 32-bit floats becomes the largest of them, as in conv3x3.wgsl: the
// 1×1 convolution would make NaN of infinity times 0.
fn relu(sum: vec4<f32>) -> vec4<f32> {
    return clamp(sum, vec4(0.0), vec4(LARGEST_F32));
}

// Whether the network must make any of `size` pixels of the tile from `first` on, which lie in
// one block: some are stored and the block is not clean.
fn is_needed(first: vec2<u32>, size: vec2<u32>) -> bool {
    let at = tile.origin + first;
    return all(at + size > tile.begin) && all(at < tile.end) && !is_clean(first);
}
