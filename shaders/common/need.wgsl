// Decides which part of a tensor a convolution must compute. Elsewhere its output stays unchanged.

struct Need {
    layer: u32,              // of the activity map
    shift: u32,              // texel of the map = pixel of the tensor >> shift
    reach: u32,              // largest distance at which to compute
    padding: u32,
}

@if(input_conv) @group(0) @binding(8) var activity: texture_2d_array<u32>;
@else @group(0) @binding(4) var activity: texture_2d_array<u32>;

@if(input_conv) @group(0) @binding(9) var<uniform> need: Need;
@else @group(0) @binding(5) var<uniform> need: Need;

// Whether the pixels under the map's texel that covers `at` are needed.
fn is_needed(at: vec2<i32>) -> bool {
    return textureLoad(activity, at >> vec2(need.shift), need.layer, 0).x <= need.reach;
}
