// The 3×3 convolution for GPUs, with or without the max-pool that follows. Where values are needed,
// they equal those of conv3x3.wgsl up to rounding.

import package::common::conv_tile::make_tile;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    make_tile(group, lane);
}
