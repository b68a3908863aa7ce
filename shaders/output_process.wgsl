// Turns the network's output into the image: inverse transfer function, inverse exposure, crop,
// blend with the noisy color, store. One pixel of the tile per invocation.

import package::common::encoding::decode;
import package::common::result::store_denoised;
import package::common::tensor::TensorIn;
import package::common::tile::tile;

@group(0) @binding(5) var input: TensorIn;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = tile.origin + id.xy;
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    store_denoised(at, decode(textureLoad(input, id.xy, 0).rgb));
}
