// The image IMAGE without bad pixels: one that is not finite in every channel is the mean of the
// finite ones among the eight around it, or, if there is none, among the 24 around it, or black.
// tile.image_size says where the image ends.
fn filled_IMAGE(at: vec2<u32>) -> vec3<f32> {
    let bits = load_IMAGE(at);
    let around = around_in_IMAGE(at, select(AROUND, 0u, is_finite(bits)));
    return select(mean(around), bitcast<vec3<f32>>(bits), is_finite(bits));
}

fn around_in_IMAGE(at: vec2<u32>, steps: u32) -> Around {
    var around = Around();
    for (var i = 0u; i < steps; i++) {
        // Beyond the left and the upper border this wraps round to more than any size.
        let there = at + vec2(i % 5u, i / 5u) - 2u;
        if all(there < tile.image_size) && any(there != at) {
            let bits = load_IMAGE(there);
            if is_finite(bits) {
                let value = clamp(bitcast<vec3<f32>>(bits), vec3(-MOST), vec3(MOST));
                let is_near = all(there + 1u >= at) && all(there <= at + 1u);
                around.wide += vec4(value, 1.0);
                around.near += select(vec4<f32>(), vec4(value, 1.0), is_near);
                let light = luminance(lit(bitcast<vec3<f32>>(bits)));
                around.brightest = max(around.brightest, select(0.0, light, is_near));
            }
        }
    }
    return around;
}

