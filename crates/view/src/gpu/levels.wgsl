// Fills a texture with an image, and its smaller mip levels with means.

struct Place {
    // Index of the first pixel in the buffer.
    first: u32,
    // Row stride of the buffer, in pixels.
    stride: u32,
    // Where the pixels go in the image, and how many there are.
    origin: vec2u,
    size: vec2u,
}

@group(0) @binding(0) var<uniform> place: Place;
// Three 32-bit floats per pixel, read as integers, so that no compiler can assume NaN away.
@group(0) @binding(1) var<storage, read> pixels: array<u32>;
@group(0) @binding(2) var image: texture_storage_2d<rgba32float, write>;

// Stores light; the last channel is 1 for a pixel with a non-finite value, otherwise 0.
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

// Averages two by two pixels; a single row or column counts twice.
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
