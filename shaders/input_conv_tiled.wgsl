// The first 3×3 convolution for GPUs, which encodes the images itself, so no tensor is stored in
// between. A workgroup computes all 16 channels, so it encodes each of its pixels once, plus a
// border of one pixel that its neighbors encode too.

import package::common::conv_tile::make_tile;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    make_tile(group, lane);
}
