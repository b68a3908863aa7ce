// Nearest upsampling: every pixel four times, as 2×2. One output pixel and four channels per
// invocation.

import package::common::tensor::{TensorIn, TensorOut};

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(output));
    let pixel = vec2<i32>(id.xy);
    let value = textureLoad(input, min(pixel, size - 1) / 2, id.z);
    if all(pixel < size) {
        textureStore(output, pixel, id.z, value);
    }
}
