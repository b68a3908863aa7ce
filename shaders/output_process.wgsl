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

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = tile.origin + id.xy;
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    let exposed = decode(textureLoad(input, id.xy, 0).rgb);
    store_denoised(at, exposed, input_scale);
}
