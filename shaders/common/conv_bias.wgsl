// The bias of a convolution for an output quad at a pixel.

import package::common::conv_output::bias;
@if(up_conv) import package::common::conv_output::output;

@if(!up_conv)
fn bias_at(at: vec2<i32>, quad: u32) -> vec4<f32> {
    return bias[quad];
}

// Beyond the border there is no upsampled tensor whose bias the convolution could see.
@if(up_conv)
fn bias_at(at: vec2<i32>, quad: u32) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(output)) - 1;
    let place = select(select(vec2(1), vec2(2), at == last), vec2(0), at == vec2(0));
    return bias[u32(place.y * 3 + place.x) * textureNumLayers(output) + quad];
}
