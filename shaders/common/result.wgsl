// Stores the result of a pixel at the end of the network. Alpha is copied from the noisy color.

import package::common::color::{alpha_of_color, load_color};
import package::common::encoding::{SIGNED, transfer_function};
import package::common::light::luminance;
import package::common::limits::LARGEST_F32;
import package::common::output::store;
import package::common::scale::input_scale;
import package::common::tile::tile;

@group(0) @binding(3) var<uniform> blend: f32;   // share of the noisy color in the result

// Noisy values that are not finite are not blended in.
fn blended(rgb: vec3<f32>, bits: vec3<u32>) -> vec3<f32> {
    let is_number = (bits & vec3(0x7f800000u)) != vec3(0x7f800000u);
    let noisy = bitcast<vec3<f32>>(select(vec3(0u), bits, is_number));
    let share = select(vec3(0.0), vec3(blend), is_number);
    return rgb * (1.0 - share) + noisy * share;
}

// Undoes the exposure. A small input scale must not produce infinity.
fn store_denoised(at: vec2<u32>, exposed: vec3<f32>) {
    store_linear(at, min(exposed / input_scale, vec3(LARGEST_F32)));
}

fn store_linear(at: vec2<u32>, rgb: vec3<f32>) {
    var result = rgb;
    // Uniform; saves reading the noisy color if it has no share.
    if blend > 0.0 {
        result = blended(result, load_color(tile.color, at));
    }
    store(at, result, alpha_of_color(tile.color, at));
}

// Stores the noisy color bit for bit, except for negative light, which the network would not see
// either. Only for clean blocks, in which all values are finite.
fn store_noisy(at: vec2<u32>) {
    var rgb = bitcast<vec3<f32>>(load_color(tile.color, at));
    if transfer_function != SIGNED && luminance(rgb) < 0.0 {
        rgb = max(rgb, vec3(0.0));
    }
    store(at, rgb, alpha_of_color(tile.color, at));
}
