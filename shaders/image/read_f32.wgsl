// Reading an image of 32-bit floats in a storage buffer. UNIFORM.IMAGE says where it stands: offset,
// row stride, pixel stride in elements, and whether the fourth element of a pixel is its alpha.
@group(0) @binding(BINDING) var<storage, read> IMAGE: array<u32>;

fn place_in_IMAGE(at: vec2<u32>) -> u32 {
    let place = UNIFORM.IMAGE;
    return place.x + at.y * place.y + at.x * place.z;
}

// The bits of a pixel's first three elements as 32-bit floats: NaN and infinity are recognised
// before any float operation sees them.
fn load_IMAGE(at: vec2<u32>) -> vec3<u32> {
    let i = place_in_IMAGE(at);
    return vec3(IMAGE[i], IMAGE[i + 1u], IMAGE[i + 2u]);
}

fn alpha_of_IMAGE(at: vec2<u32>) -> f32 {
    if UNIFORM.IMAGE.w == 0u {
        return 1.0;
    }
    return bitcast<f32>(IMAGE[place_in_IMAGE(at) + 3u]);
}

