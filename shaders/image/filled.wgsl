// The image IMAGE without bad pixels: one that is not finite in every channel is the mean of the
// finite ones among the eight around it, or, if there is none, among the 24 around it, or black.
// tile.image_size says where the image ends.

fn is_finite_in_IMAGE(bits: vec3<u32>) -> bool {
    return all((bits & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

fn filled_IMAGE(at: vec2<u32>) -> vec3<f32> {
    let bits = load_IMAGE(at);
    if is_finite_in_IMAGE(bits) {
        return bitcast<vec3<f32>>(bits);
    }
    var around = sum_around_in_IMAGE(at, 1u);
    if around.w == 0.0 {
        around = sum_around_in_IMAGE(at, 2u);
    }
    return around.xyz / max(around.w, 1.0);
}

// The finite pixels up to `distance` away: their sum and how many they are.
fn sum_around_in_IMAGE(at: vec2<u32>, distance: u32) -> vec4<f32> {
    let begin = max(at, vec2(distance)) - distance;
    let end = min(at + distance + 1u, tile.image_size);
    var sum = vec4<f32>();
    for (var y = begin.y; y < end.y; y++) {
        for (var x = begin.x; x < end.x; x++) {
            let bits = load_IMAGE(vec2(x, y));
            if is_finite_in_IMAGE(bits) {
                // Sums of 24 stay within f32.
                sum += vec4(clamp(bitcast<vec3<f32>>(bits), vec3(-1e30), vec3(1e30)), 1.0);
            }
        }
    }
    return sum;
}

