// The input of a 3×3 convolution: a tensor, or the images, which it encodes itself.

@if(input_conv) import package::common::conv_output::output;
@if(input_conv) import package::common::encoded::{encoded_albedo, encoded_color, encoded_normal};
@if(input_conv) import package::common::inputs::{has_albedo, has_normal};
@if(input_conv) import package::common::place::place;
@else import package::common::tensor::TensorIn;

@if(!input_conv) @group(0) @binding(0) var input: TensorIn;

@if(!input_conv)
fn input_size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(input));
}

@if(!input_conv)
fn input_quads() -> u32 {
    return textureNumLayers(input);
}

@if(!input_conv)
fn load_input(at: vec2<i32>, quad: u32) -> vec4<f32> {
    return textureLoad(input, at, quad);
}

// The convolution's input is as large as its output.
@if(input_conv)
fn input_size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(output));
}

@if(input_conv)
fn input_quads() -> u32 {
    return 1u + u32(has_albedo) + u32(has_normal);
}

// Each image is a quad of its own.
@if(input_conv)
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
