// Writing an image in a storage texture.
@group(0) @binding(BINDING) var output: texture_storage_2d<FORMAT, write>;

const LARGEST_STORED = vec3(LARGEST);

fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    textureStore(output, at, vec4(clamp(rgb, -LARGEST_STORED, LARGEST_STORED), alpha));
}

