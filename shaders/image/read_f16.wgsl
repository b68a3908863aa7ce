// Reading an image of 16-bit floats in a storage buffer, two to a word. UNIFORM.IMAGE says where it
// stands: offset, row stride, pixel stride in elements, and whether the fourth element of a pixel
// is its alpha.
@group(0) @binding(BINDING) var<storage, read> IMAGE: array<u32>;

fn place_in_IMAGE(at: vec2<u32>) -> u32 {
    let place = UNIFORM.IMAGE;
    return place.x + at.y * place.y + at.x * place.z;
}

// The bits of an element as a 32-bit float. unpack2x16float need not keep NaN and infinity.
fn element_of_IMAGE(i: u32) -> u32 {
    let half = (IMAGE[i / 2u] >> (16u * (i & 1u))) & 0xffffu;
    let special = ((half & 0x8000u) << 16u) | 0x7f800000u | ((half & 0x3ffu) << 13u);
    return select(bitcast<u32>(unpack2x16float(half).x), special, (half & 0x7c00u) == 0x7c00u);
}

fn load_IMAGE(at: vec2<u32>) -> vec3<u32> {
    let i = place_in_IMAGE(at);
    return vec3(element_of_IMAGE(i), element_of_IMAGE(i + 1u), element_of_IMAGE(i + 2u));
}

fn alpha_of_IMAGE(at: vec2<u32>) -> f32 {
    if UNIFORM.IMAGE.w == 0u {
        return 1.0;
    }
    return bitcast<f32>(element_of_IMAGE(place_in_IMAGE(at) + 3u));
}

