// Writing an image in a storage texture.
@group(0) @binding(BINDING) var output: texture_storage_2d<FORMAT, write>;

const LARGEST_STORED = vec4(LARGEST);

fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    textureStore(output, at, clamp(vec4(rgb, alpha), -LARGEST_STORED, LARGEST_STORED));
}

