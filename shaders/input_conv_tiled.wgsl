// The first 3×3 convolution for GPUs, which encodes the images itself, so no tensor is stored in
// between. A workgroup computes all 16 channels, so it encodes each of its pixels once, plus a
// border of one pixel that its neighbors encode too.

import package::common::conv_tile::make_tile;
import package::common::conv_output::output;
import package::common::encoded::{encoded_albedo, encoded_color, encoded_normal};
import package::common::inputs::{has_albedo, has_normal};
import package::common::place::place;

// The convolution's input is as large as its output.
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

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    make_tile(group, local.xy, lane);
}
