// What the end of the network does with a pixel, between the noisy image `color` and the image
// `output`. Alpha is carried over.
@group(0) @binding(BINDING) var<uniform> blend: f32;   // share of the noisy colour in the result

// A noisy value that is no number has no share.
fn blended(rgb: vec3<f32>, bits: vec3<u32>) -> vec3<f32> {
    let is_finite = (bits & vec3(0x7f800000u)) != vec3(0x7f800000u);
    let noisy = bitcast<vec3<f32>>(select(vec3(0u), bits, is_finite));
    let share = select(vec3(0.0), vec3(blend), is_finite);
    return rgb * (1.0 - share) + noisy * share;
}

const HIGHEST = 3.4028234e38; // the largest 32-bit float: a small exposure must make no infinity

fn store_denoised(at: vec2<u32>, exposed: vec3<f32>, input_scale: f32) {
    var result = min(exposed / input_scale, vec3(HIGHEST));
    // The same for all: the noisy colour is not read for nothing.
    if blend > 0.0 {
        result = blended(result, load_color(at));
    }
    store(at, result, alpha_of_color(at));
}

// Finite and not negative: bits in the order of their values, up to infinity; or −0.
fn is_light(bits: vec3<u32>) -> bool {
    return all((bits < vec3(0x7f800000u)) | (bits == vec3(0x80000000u)));
}

// Bit for bit, unless the noisy colour is no light.
fn store_noisy(at: vec2<u32>) {
    let bits = load_color(at);
    var rgb = bitcast<vec3<f32>>(bits);
    if !is_light(bits) {
        rgb = max(filled_color(at), vec3(0.0));
    }
    store(at, rgb, alpha_of_color(at));
}

