// The first 3×3 convolution for GPUs, which encodes the images itself: no tensor is stored between.
// A workgroup makes 16 channels, all there are, so that it encodes each pixel once, and a border of
// one pixel that its neighbours encode too. Stands after input_process.wgsl's declarations, whose
// `output` is the convolution's here, and before what follows the inputs in conv3x3_tiled.wgsl.

// [input quad][tap][output quad]: one mat4x4 as in conv3x3.wgsl.
@group(0) @binding(6) var<storage, read> conv_weights: array<mat4x4<f32>>;
@group(0) @binding(7) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(8) var activity: texture_2d_array<u32>;
@group(0) @binding(9) var<uniform> need: Need;

fn input_size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(output));
}

fn input_quads() -> u32 {
    return 1u + u32(has_albedo) + u32(has_normal);
}

// Each image is a quad of its own.
fn load_input(pixel: vec2<i32>, quad: u32) -> vec4<f32> {
    let at = place(vec2<u32>(pixel));
    if quad == 0u {
        return encoded_color(at);
    }
    if has_albedo && quad == 1u {
        return encoded_albedo(at);
    }
    return encoded_normal(at);
}

