// From the network's output to the image: inverse transfer function, exposure taken back, crop,
// blend with the noisy colour, store. One pixel of the tile per invocation.

alias TensorIn = texture_storage_2d_array<rgba32float, read>;

struct Tile {
    image_size: vec2<u32>,   // of the bound images, pixels
    origin: vec2<u32>,       // the tile's first pixel in the bound images
    begin: vec2<u32>,        // the pixels to store: from `begin`
    end: vec2<u32>,          // up to and without `end`, in the bound images
    color: vec4<u32>,        // offset, row stride, pixel stride, in elements
    albedo: vec4<u32>,
    normal: vec4<u32>,
    output: vec4<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var input: TensorIn;
@group(0) @binding(2) var<storage, read> input_scale: f32;
// Bindings 3 to 5: the images `color` and `output` and their blend, by texts of shaders/image.

// The inverse of the transfer function in input_process.wgsl.
const A = 1.41283765e3;
const B = 1.64593172;
const C = 0.431384981;
const D = -2.94139609e-3;
const E = 0.192653254;
const F = 6.26026094e-3;
const G = 0.998620152;
const X0 = 2.23151711e-3;
const X1 = 0.370974749;
const SCALE = 1.0 / 3.13511904;

fn inverse_transfer(encoded: f32) -> f32 {
    let x = encoded / SCALE;
    let middle = pow(max((x - D) / B, 0.0), 1.0 / C);
    let bright = exp((x - G) / E) - F;
    return max(select(select(bright, middle, x <= X1), x / A, x <= X0), 0.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = tile.origin + id.xy;
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    // 65504 is encoded as 1: nothing brighter went in, and exp must not overflow.
    let encoded = clamp(textureLoad(input, id.xy, 0), vec4(0.0), vec4(1.0));
    let exposed = vec3(
        inverse_transfer(encoded.x), inverse_transfer(encoded.y), inverse_transfer(encoded.z),
    );
    store_denoised(at, exposed / input_scale);
}
