// The network's input at a pixel, image by image: repaired, exposed and encoded.

import package::common::encoding::{SIGNED, encode, transfer_function};
import package::common::fill::filled;
import package::common::images::NORMAL;
import package::common::inputs::unorm_normal;
import package::common::reflectance::reflectance;
import package::common::repair::repaired;
import package::common::scale::input_scale;

fn encoded_color(at: vec2<u32>) -> vec4<f32> {
    let rgb = repaired(at).rgb;
    let numbers = select(max(rgb, vec3(0.0)), rgb, transfer_function == SIGNED);
    return vec4(encode(numbers * input_scale), 0.0);
}

fn encoded_albedo(at: vec2<u32>) -> vec4<f32> {
    return vec4(reflectance(at), 0.0);
}

fn encoded_normal(at: vec2<u32>) -> vec4<f32> {
    let xyz = filled(NORMAL, at).xyz;
    if unorm_normal {
        let encoded = clamp(xyz, vec3(0.0), vec3(1.0));
        return vec4(select(encoded, vec3(0.5), all(xyz == vec3(0.0))), 0.0);
    }
    return vec4(clamp(xyz, vec3(-1.0), vec3(1.0)) * 0.5 + 0.5, 0.0);
}
