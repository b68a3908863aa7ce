// The 3×3 convolution for GPUs, with or without the max-pool that follows. Same values as
// conv3x3.wgsl up to rounding, where they are needed.

import package::common::conv_tile::make_tile;

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    make_tile(group, local.xy, lane);
}
