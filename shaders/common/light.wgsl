// Constants of light: middle gray and the limits of brightness.

const GREY: f32 = 0.18;      // the average luminance times input_scale
const MOST: f32 = 1e30;      // sums and quotients of values clamped to this stay within f32
const INFINITE = 0x7f800000u;   // the bits of +∞

fn is_finite(bits: vec3<u32>) -> bool {
    return all((bits & vec3(INFINITE)) != vec3(INFINITE));
}

fn with_infinity(bits: vec3<u32>, infinite: u32) -> vec3<u32> {
    return select(bits, vec3(infinite), bits == vec3(INFINITE));
}

fn lit(rgb: vec3<f32>) -> vec3<f32> {
    return clamp(rgb, vec3(0.0), vec3(MOST));
}

fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3(0.212671, 0.715160, 0.072169));
}
