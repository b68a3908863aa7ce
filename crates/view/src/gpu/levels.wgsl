// Fills a texture with an image, and its smaller levels with means.

struct Place {
    // The first pixel in the buffer.
    first: u32,
    // Pixels from one row of the buffer to the next.
    stride: u32,
    // Where the pixels belong in the image, and how many there are.
    origin: vec2u,
    size: vec2u,
}

@group(0) @binding(0) var<uniform> place: Place;
// Three 32-bit floats per pixel. As integers, so that no compiler may take NaN for impossible.
@group(0) @binding(1) var<storage, read> pixels: array<u32>;
@group(0) @binding(2) var image: texture_storage_2d<rgba32float, write>;

// Stores light, and 1 in the last channel of a pixel with a value that is no finite number.
@compute @workgroup_size(8, 8)
fn place_pixels(@builtin(global_invocation_id) at: vec3u) {
    if any(at.xy >= place.size) {
        return;
    }
    let i = 3u * (place.first + at.y * place.stride + at.x);
    let bits = vec3u(pixels[i], pixels[i + 1u], pixels[i + 2u]);
    let exponents = vec3u(0x7f800000u);
    let is_broken = any((bits & exponents) == exponents);
    let texel = select(vec4f(bitcast<vec3f>(bits), 0.0), vec4f(0.0, 0.0, 0.0, 1.0), is_broken);
    textureStore(image, place.origin + at.xy, texel);
}

@group(0) @binding(0) var larger: texture_2d<f32>;
@group(0) @binding(1) var smaller: texture_storage_2d<rgba32float, write>;

// The mean of two by two pixels, or of as many as there are.
@compute @workgroup_size(8, 8)
fn halve(@builtin(global_invocation_id) at: vec3u) {
    if any(at.xy >= textureDimensions(smaller)) {
        return;
    }
    let last = textureDimensions(larger) - 1u;
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += 0.25 * textureLoad(larger, min(2u * at.xy + vec2u(i & 1u, i >> 1u), last), 0);
    }
    textureStore(smaller, at.xy, sum);
}
