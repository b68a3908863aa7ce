// What the end of the network does with a pixel, between the noisy image `color` and the image
// `output`. Alpha is carried over.
@group(0) @binding(BINDING) var<uniform> blend: f32;   // share of the noisy colour in the result

fn store_denoised(at: vec2<u32>, rgb: vec3<f32>) {
    let bits = load_color(at);
    // A noisy value that is no number has no share.
    let is_finite = (bits & vec3(0x7f800000u)) != vec3(0x7f800000u);
    let noisy = bitcast<vec3<f32>>(select(vec3(0u), bits, is_finite));
    let share = select(vec3(0.0), vec3(blend), is_finite);
    store(at, rgb * (1.0 - share) + noisy * share, alpha_of_color(at));
}

fn store_noisy(at: vec2<u32>) {
    store(at, bitcast<vec3<f32>>(load_color(at)), alpha_of_color(at));
}

