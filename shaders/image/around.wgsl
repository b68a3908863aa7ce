// What stands around a pixel of an image, for the texts that repair it: the finite pixels among the
// eight nearest and among the 24 nearest, as sums and, in w, counts; and the most light among the
// eight.
struct Around {
    near: vec4<f32>,
    wide: vec4<f32>,
    brightest: f32,
}

// How many steps look at all of 5×5 pixels. CPU drivers take all branches for all pixels, but leave
// loops without a step early: so what is rarely needed is a loop of none or AROUND steps.
const AROUND = 25u;

fn is_finite(bits: vec3<u32>) -> bool {
    return all((bits & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

// Sums and quotients of what is clamped to this stay within f32.
const MOST = 1e30;

fn lit(rgb: vec3<f32>) -> vec3<f32> {
    return clamp(rgb, vec3(0.0), vec3(MOST));
}

fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3(0.212671, 0.715160, 0.072169));
}

fn mean(around: Around) -> vec3<f32> {
    let sum = select(around.near, around.wide, around.near.w == 0.0);
    return sum.xyz / max(sum.w, 1.0);
}

