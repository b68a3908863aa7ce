// The end of the network in one kernel: 1×1 convolution, sigmoid or none, inverse transfer function,
// exposure taken back, crop, blend with the noisy colour, store. Clean blocks get their input, its
// bad pixels filled, instead. One pixel of the tile per invocation. Equals conv1x1.wgsl,
// sigmoid.wgsl and output_process.wgsl one after the other.

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
// Row = input quad, texel = input channel of it: what that channel adds to the outputs. The last
// row begins with the bias.
@group(0) @binding(2) var weights: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(3) var<storage, read> input_scale: f32;
// Whether each 16×16 block of the tile is clean, row by row.
@group(0) @binding(4) var<storage, read> clean: array<u32>;
// Bindings 5 to 7: the images `color` and `output` and their blend, by texts of shaders/image.

const BLOCK = 16u;

override sigmoid: bool;      // whether there is one

fn is_clean(pixel: vec2<u32>) -> bool {
    let block = pixel / BLOCK;
    return clean[block.y * (textureDimensions(input).x / BLOCK) + block.x] != 0u;
}

// Stores what the sums of the 1×1 convolution at a pixel of the tile come to.
fn finish(pixel: vec2<i32>, sums: vec4<f32>) {
    let at = tile.origin + vec2<u32>(pixel);
    if any(at < tile.begin) || any(at >= tile.end) {
        return;
    }
    if is_clean(vec2<u32>(pixel)) {
        store_noisy(at);
        return;
    }
    let bias = textureLoad(weights, vec2(0, i32(textureDimensions(weights).y) - 1), 0);
    // Beyond ±30 the sigmoid is within 1e-13 of 0 or 1, and exp stays far from overflow.
    let x = clamp(sums + bias, vec4(-30.0), vec4(30.0));
    let encoded = select(x, 1.0 / (1.0 + exp(-x)), sigmoid);
    let exposed = decode(encoded.rgb);
    store_denoised(at, exposed, input_scale);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = vec2<i32>(id.xy);
    var sums = vec4<f32>();
    for (var quad = 0; quad < i32(textureNumLayers(input)); quad++) {
        let value = textureLoad(input, pixel, quad);
        sums += textureLoad(weights, vec2(0, quad), 0) * value.x;
        sums += textureLoad(weights, vec2(1, quad), 0) * value.y;
        sums += textureLoad(weights, vec2(2, quad), 0) * value.z;
        sums += textureLoad(weights, vec2(3, quad), 0) * value.w;
    }
    finish(pixel, sums);
}
