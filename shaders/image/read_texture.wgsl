// Reading an image in a texture.
@group(0) @binding(BINDING) var IMAGE: texture_2d<f32>;

// The bits of a pixel's first three channels as 32-bit floats.
fn load_IMAGE(at: vec2<u32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(textureLoad(IMAGE, at, 0).rgb);
}

fn alpha_of_IMAGE(at: vec2<u32>) -> f32 {
    return textureLoad(IMAGE, at, 0).a;
}

