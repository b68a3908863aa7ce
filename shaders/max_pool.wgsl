// Maximum over 2×2 pixels. One output pixel and four channels per invocation.

import package::common::tensor::{TensorIn, TensorOut};

@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(output));
    let pixel = vec2<i32>(id.xy);
    let corner = min(pixel, size - 1) * 2;
    let upper = max(
        textureLoad(input, corner, id.z),
        textureLoad(input, corner + vec2(1, 0), id.z),
    );
    let lower = max(
        textureLoad(input, corner + vec2(0, 1), id.z),
        textureLoad(input, corner + vec2(1, 1), id.z),
    );
    if all(pixel < size) {
        textureStore(output, pixel, id.z, max(upper, lower));
    }
}
