// Writing an image of 16-bit floats in a storage buffer, two to a word. tile.output says where it
// stands: offset, row stride, pixel stride in elements, and whether the fourth element of a pixel
// is its alpha.
@group(0) @binding(BINDING) var<storage, read_write> output: array<atomic<u32>>;

const LARGEST_STORED = 65504.0;

// Neighbours can share a word: each changes its own bits only.
fn store_element(i: u32, value: f32) {
    let half = pack2x16float(vec2(clamp(value, -LARGEST_STORED, LARGEST_STORED), 0.0));
    let shift = 16u * (i & 1u);
    atomicAnd(&output[i / 2u], ~(0xffffu << shift));
    atomicOr(&output[i / 2u], half << shift);
}

fn store(at: vec2<u32>, rgb: vec3<f32>, alpha: f32) {
    let place = tile.output;
    let i = place.x + at.y * place.y + at.x * place.z;
    store_element(i, rgb.r);
    store_element(i + 1u, rgb.g);
    store_element(i + 2u, rgb.b);
    if place.w != 0u {
        store_element(i + 3u, alpha);
    }
}

