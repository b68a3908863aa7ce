// The end of the network in one kernel: 1×1 convolution, and what `finish` makes of it. One pixel of
// the tile per invocation. Equals conv1x1.wgsl, sigmoid.wgsl and output_process.wgsl one after the
// other, except in clean blocks.

import package::common::head::{finish, input, weights};

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = vec2<i32>(id.xy);
    var sums = vec4<f32>();
    for (var quad = 0; quad < i32(textureNumLayers(input)); quad++) {
        let value = textureLoad(input, pixel, quad);
        sums += textureLoad(weights, vec2(0, quad), 0) * value.x;
        sums += textureLoad(weights, vec2(1, quad), 0) * value.y;
        sums += textureLoad(weights, vec2(2, quad), 0) * value.z;
        sums += textureLoad(weights, vec2(3, quad), 0) * value.w;
    }
    finish(pixel, sums);
}
