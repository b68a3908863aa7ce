// Writing an image of 32-bit floats in a storage buffer. tile.output says where it stands: offset,
// row stride, pixel stride in elements, and whether the fourth element of a pixel is its alpha.
@group(0) @binding(BINDING) var<storage, read_write> output: array<f32>;

fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    let place = tile.output;
    let i = place.x + at.y * place.y + at.x * place.z;
    output[i] = rgb.r;
    output[i + 1u] = rgb.g;
    output[i + 2u] = rgb.b;
    if place.w != 0u {
        output[i + 3u] = alpha;
    }
}

